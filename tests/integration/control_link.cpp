// Programs that join the gateway with GET /link, and single frames sent with POST /send.
#include <config/difference.hpp>
#include <support/controlled_gateway.hpp>
#include <support/process.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <thread>
#include <vector>

namespace control_link_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::http::Answer;
using anogate::http::WebSocket;
using nlohmann::json;

std::string hex_of(const Bytes& bytes) {
    std::string text;
    for (const std::uint8_t byte : bytes) {
        constexpr char digits[] = "0123456789ABCDEF";
        text += {digits[byte >> 4], digits[byte & 15]};
    }
    return text;
}

json body_of(const Answer& answer) { return json::parse(answer.body, nullptr, false); }

bool has_link(ControlledGateway& gateway, const std::string& name) {
    const json status = gateway.gateway.status();
    for (const auto& link : status.at("links"))
        if (link.at("name") == name) return true;
    return false;
}

class ControlLinkOfOnePeer : public testing::Test {
protected:
    bool until_open(MessageClient& message_client) {
        return gateway.gateway.until([&] { return message_client.is_open(); }) &&
               gateway.gateway.until([&] { return has_link(gateway, "control"); });
    }
    bool until_channels(std::size_t count) {
        return gateway.gateway.until([&] { return gateway.gateway.link("control").at("channels").size() == count; });
    }
    bool receives(const Bytes& wanted) {
        return gateway.gateway.until([&] { return peer.heard() == wanted; });
    }
    void send(const Bytes& bytes) { peer.send(gateway.gateway.port("peer"), bytes); }

    UdpPeer peer;
    ControlledGateway gateway{{peer.link("peer")}};
};

const Bytes from_program = frame(0xA1, 0xFF, 0x03, {1, 2, 3, 4, 5, 6, 7});

TEST_F(ControlLinkOfOnePeer, does_not_exist_until_it_is_used) {
    EXPECT_FALSE(has_link(gateway, "control"));
    EXPECT_EQ(gateway.ask("GET", "/link").status, 426u);
    EXPECT_FALSE(has_link(gateway, "control"));
    MessageClient program{gateway, "/link"};
    ASSERT_TRUE(until_open(program));
    EXPECT_EQ(gateway.gateway.link("control").at("state"), "up");
}

TEST_F(ControlLinkOfOnePeer, a_program_is_a_channel_like_any_other) {
    MessageClient a{gateway, "/link?name=a"}, b{gateway, "/link?name=b"};
    ASSERT_TRUE(until_open(a) && until_open(b) && until_channels(2));
    a.send(from_program + frame(0xA1, 0xFF, 0x09, {1}));
    EXPECT_TRUE(receives(from_program + frame(0xA1, 0xFF, 0x09, {1}))) << "one message, two frames";
    EXPECT_TRUE(gateway.gateway.until([&] { return b.bytes() == from_program + frame(0xA1, 0xFF, 0x09, {1}); }));
    EXPECT_TRUE(a.messages().empty()) << "never back";
    EXPECT_EQ(gateway.gateway.route("0xA1").at("links"), json{"control"});
    const Bytes answer = frame(0xDC, 0xA1, 0x00, {1, 2, 3});
    send(answer);
    EXPECT_TRUE(gateway.gateway.until([&] { return a.bytes() == answer; }));
    EXPECT_EQ(b.bytes(), from_program + frame(0xA1, 0xFF, 0x09, {1})) << "it is for the other alone";
    const json link = gateway.gateway.link("control");
    EXPECT_EQ(link.at("channels").at(0).at("peer"), "a");
    EXPECT_EQ(link.at("channels").at(0).at("frames_in"), 2);
    EXPECT_EQ(link.at("channels").at(0).at("frames_out"), 1);
    EXPECT_TRUE(gateway.gateway.counters_add_up());
    a.leave();
    EXPECT_TRUE(until_channels(1));
    EXPECT_EQ(gateway.gateway.count("control", "frames_in"), 2u);
}

TEST_F(ControlLinkOfOnePeer, bytes_that_are_not_a_whole_frame_are_counted_and_reported) {
    MessageClient program{gateway, "/link"};
    ASSERT_TRUE(until_open(program) && until_channels(1));
    Bytes half = from_program;
    half.resize(9);
    program.send(frame(0xA1, 0xFF, 0x09, {1}) + half);
    program.send(from_program);    // the rest of a message is not the beginning of the next
    EXPECT_TRUE(receives(frame(0xA1, 0xFF, 0x09, {1}) + from_program));
    ASSERT_TRUE(gateway.gateway.until([&] { return program.texts().size() == 1; }));
    EXPECT_EQ(json::parse(program.texts().front()).at("error"),
              "9 bytes of a message were not part of a complete frame and were ignored");
    EXPECT_EQ(gateway.gateway.count("control", "skipped_bytes"), 9u);
    program.send("hello", WebSocket::Kind::text);
    ASSERT_TRUE(gateway.gateway.until([&] { return program.texts().size() == 2; }));
    EXPECT_NE(program.texts().back().find("text messages are not accepted"), std::string::npos);
    program.send(Bytes{});
    program.send(from_program);
    EXPECT_TRUE(gateway.gateway.until([&] { return gateway.gateway.count("control", "frames_in") == 3; }));
    EXPECT_EQ(program.texts().size(), 2u);
}

TEST_F(ControlLinkOfOnePeer, a_program_can_have_a_port_id) {
    MessageClient program{gateway, "/link?name=camera&id=7"}, other{gateway, "/link"};
    ASSERT_TRUE(until_open(program) && until_open(other) && until_channels(2));
    const Bytes to_port = frame(0xDC, 7, 0x03, {1, 2, 3, 4, 5, 6, 7});
    send(to_port);
    EXPECT_TRUE(gateway.gateway.until([&] { return program.bytes() == to_port; }));
    EXPECT_TRUE(other.messages().empty());
    EXPECT_EQ(gateway.gateway.route("0x07").at("via"), "port");
    MessageClient second{gateway, "/link?id=0x07"};
    ASSERT_TRUE(gateway.gateway.until([&] { return second.ended.has_value(); }));
    EXPECT_EQ(second.ended->answer.status, 409u);
    for (const std::string wrong : {"id=21", "id=0", "id=x", "name=", "name=a%07b"}) {
        MessageClient refused{gateway, "/link?" + wrong};
        ASSERT_TRUE(gateway.gateway.until([&] { return refused.ended.has_value(); })) << wrong;
        EXPECT_EQ(refused.ended->answer.status, 400u) << wrong;
    }
    program.leave();
    EXPECT_TRUE(until_channels(1));
    MessageClient next{gateway, "/link?id=7"};
    EXPECT_TRUE(until_open(next));
}

TEST_F(ControlLinkOfOnePeer, a_program_is_closed_when_a_link_or_the_gateway_gets_its_port_id) {
    MessageClient camera{gateway, "/link?id=7"}, lamp{gateway, "/link?id=8"}, radio{gateway, "/link?id=9"};
    ASSERT_TRUE(until_open(camera) && until_open(lamp) && until_open(radio) && until_channels(3));
    anogate::Gateway& running = gateway.gateway.gateway();
    anogate::Settings settings = running.settings();
    settings.links.at(0).id = 7;
    settings.gateway.id = 8;
    bool changed = false;
    running.change(settings, anogate::difference(running.settings(), settings), 300ms, [&] { changed = true; });
    ASSERT_TRUE(gateway.gateway.until([&] { return changed && camera.ended && lamp.ended; }));
    EXPECT_EQ(camera.ended->fault, "closed by the gateway: another link has the port id 7 now");
    EXPECT_EQ(lamp.ended->fault, "closed by the gateway: the gateway has the port id 8 now");
    EXPECT_TRUE(until_channels(1));
    EXPECT_EQ(gateway.gateway.route("0x07").at("links"), json{"peer"});
    EXPECT_FALSE(radio.ended) << "its id is its own";
}

TEST_F(ControlLinkOfOnePeer, a_program_that_does_not_read_has_a_bounded_queue) {
    const int fd = connect_unix(gateway.path);
    ASSERT_GE(fd, 0);
    const std::string request =
        "GET /link HTTP/1.1\r\nHost: x\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n";
    ASSERT_EQ(::send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    ASSERT_TRUE(gateway.gateway.until([&] { return has_link(gateway, "control"); }) && until_channels(1));
    MessageClient reads{gateway, "/link"};
    ASSERT_TRUE(until_open(reads) && until_channels(2));
    const auto dropped = [&] { return gateway.gateway.count("control", "queue_full"); };
    for (int i = 0; i < 2000 && dropped() == 0; ++i) {
        send(frame(0xDC, 0xFF, 0xF1, Bytes(4000, static_cast<std::uint8_t>(i))));
        const auto seen = static_cast<std::uint64_t>(i) + 1;
        ASSERT_TRUE(gateway.gateway.until([&] { return gateway.gateway.count("peer", "frames_in") == seen; }));
    }
    EXPECT_GT(dropped(), 0u);
    const std::size_t sent = gateway.gateway.count("peer", "frames_in");
    EXPECT_TRUE(gateway.gateway.until([&] { return reads.bytes().size() == sent * 4008; })) << "who reads has them all";
    EXPECT_TRUE(gateway.gateway.counters_add_up());
    ::close(fd);
    EXPECT_TRUE(until_channels(1));
}

TEST(ControlLink, supports_the_same_rules_as_any_other_link) {
    UdpPeer peer;
    anogate::Settings settings = settings_of_texts({peer.link("peer")});
    settings.control.rules.receive.deny = {{0x09, 0x09}};
    settings.control.rules.send.deny = {{0x01, 0x01}};
    settings.control.rules.limit = {{0x03, 0.001}};
    ControlledGateway gateway{settings};
    EXPECT_TRUE(has_link(gateway, "control")) << "from the start: it is configured";
    MessageClient program{gateway, "/link"};
    ASSERT_TRUE(
        gateway.gateway.until([&] { return program.is_open() && gateway.gateway.link("control").at("channels").size() == 1; }));
    program.send(frame(0xA1, 0xFF, 0x09, {1}) + from_program);
    EXPECT_TRUE(gateway.gateway.until([&] { return peer.heard() == from_program; }));
    EXPECT_EQ(gateway.gateway.count("control", "denied_in"), 1u);
    for (const std::uint8_t id : {std::uint8_t{0x01}, std::uint8_t{0x03}, std::uint8_t{0x03}})
        peer.send(gateway.gateway.port("peer"), frame(0xDC, 0xFF, id, {1, 2, 3, 4}));
    EXPECT_TRUE(gateway.gateway.until([&] { return gateway.gateway.count("control", "limited") == 1; }));
    EXPECT_EQ(gateway.gateway.count("control", "denied_out"), 1u);
    EXPECT_TRUE(gateway.gateway.until([&] { return program.bytes() == frame(0xDC, 0xFF, 0x03, {1, 2, 3, 4}); }));
    EXPECT_EQ(gateway.ask("POST", "/send", R"({"to": 220, "id": 9, "data": "01"})").status, 409u);
    EXPECT_EQ(gateway.gateway.count("control", "denied_in"), 2u);
}

TEST_F(ControlLinkOfOnePeer, the_answer_names_the_links_that_sent_a_frame) {
    const Bytes command = frame(0xFE, 0xDC, 0xE0, {0, 1, 0});
    const Answer sent = gateway.ask("POST", "/send", R"({"hex": ")" + hex_of(command) + R"("})");
    EXPECT_EQ(sent.status, 200u) << sent.body;
    const json told = body_of(sent);
    ASSERT_EQ(told.at("sent").size(), 1u) << sent.body;
    EXPECT_EQ(told.at("sent").at(0).at("link"), "peer");
    EXPECT_TRUE(told.at("waiting").empty() && told.at("dropped").empty()) << sent.body;
    EXPECT_TRUE(receives(command));
    EXPECT_EQ(gateway.gateway.count("control", "frames_in"), 1u);
    const Answer as_json = gateway.ask("POST", "/send", R"({"to": 255, "name": "wind", "fields": {"wind_x": 1}})");
    EXPECT_EQ(as_json.status, 200u) << as_json.body;
    EXPECT_TRUE(receives(command + frame(0xFE, 0xFF, 0x09, {1, 0, 0, 0})));
}

TEST_F(ControlLinkOfOnePeer, a_sent_frame_does_not_change_routing) {
    MessageClient program{gateway, "/link"};
    ASSERT_TRUE(until_open(program) && until_channels(1));
    EXPECT_EQ(gateway.ask("POST", "/send", R"({"from": 254, "to": 255, "name": "wind"})").status, 200u);
    EXPECT_EQ(gateway.ask("POST", "/send", R"({"from": 30, "to": 255, "name": "wind"})").status, 200u);
    EXPECT_EQ(gateway.gateway.route("0xFE"), nullptr);
    EXPECT_EQ(gateway.gateway.route("0x1E"), nullptr);
    send(frame(0x1E, 0xFE, 0x03, {1, 2, 3, 4, 5, 6, 7}));
    EXPECT_TRUE(gateway.gateway.until([&] { return gateway.gateway.route("0x1E") != nullptr; }));
    const json before = gateway.gateway.status();
    EXPECT_EQ(gateway.ask("POST", "/send", R"({"from": 30, "to": 255, "name": "wind"})").status, 200u);
    const json after = gateway.gateway.status();
    EXPECT_EQ(after.at("routes").at(0).at("links"), before.at("routes").at(0).at("links"));
    EXPECT_TRUE(after.at("conflicts").empty());
    EXPECT_EQ(after.at("routes").size(), before.at("routes").size());
}

TEST_F(ControlLinkOfOnePeer, a_frame_that_cannot_be_sent_is_reported_with_the_reason) {
    const auto refused = [&](const std::string& body, unsigned status) {
        const Answer answer = gateway.ask("POST", "/send", body);
        EXPECT_EQ(answer.status, status) << answer.body;
        const json told = body_of(answer);
        return told.is_object() ? told.value("error", "") : "not an object: " + answer.body;
    };
    const std::string whole = hex_of(frame(1, 2, 3, {4}));
    EXPECT_NE(refused("[]", 400).find("must be an object"), std::string::npos);
    EXPECT_NE(refused("{\"hex\": \"AB\"", 400), "");
    EXPECT_NE(refused(R"({"hex": 5})", 400).find("text"), std::string::npos);
    EXPECT_NE(refused(R"({"hex": "ABC"})", 400).find("pairs"), std::string::npos);
    EXPECT_NE(refused(R"({"hex": ")" + whole + whole + R"("})", 400).find("one complete frame"), std::string::npos);
    EXPECT_NE(refused(R"({"hex": ")" + whole + R"(", "to": 3})", 400).find("no other keys"), std::string::npos);
    EXPECT_NE(refused(R"({"name": "eular"})", 400).find("euler"), std::string::npos);
    EXPECT_NE(refused(R"({"name": "euler", "fields": {"rll": 1}})", 400).find("/fields/rll"), std::string::npos);
    EXPECT_FALSE(has_link(gateway, "control")) << "nothing was sent";
    const Answer nowhere = gateway.ask("POST", "/send", R"({"to": 0, "name": "wind"})");
    EXPECT_EQ(nowhere.status, 409u);
    EXPECT_EQ(body_of(nowhere).at("dropped").at(0).at("cause"), "no_route");
    EXPECT_EQ(body_of(nowhere).at("what"), "refused");
    EXPECT_NE(body_of(nowhere).value("error", "").find("not sent"), std::string::npos);
    EXPECT_TRUE(peer.heard().empty());
}

TEST(ControlLink, a_request_that_waited_during_a_stall_is_not_carried_out) {
    UdpPeer peer;
    TempDir dir;
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {peer.link("peer")}};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    const std::string body = R"({"to": 255, "name": "wind"})";
    const std::string request = "POST /send HTTP/1.0\r\nContent-Type: application/json\r\nContent-Length: " +
                                std::to_string(body.size()) + "\r\n\r\n" + body;
    EXPECT_EQ(http(socket, request).substr(9, 3), "200");
    EXPECT_TRUE(wait_until([&] { return peer.heard().size() == 12; }));
    daemon.signal(SIGSTOP);
    const int fd = connect_unix(socket);
    ASSERT_GE(fd, 0);
    ASSERT_EQ(::send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    std::this_thread::sleep_for(1500ms);    // longer than the interval of the loop's beats, so that the gateway stalled
    daemon.signal(SIGCONT);
    const std::string answer = read_to_end(fd);
    ::close(fd);
    EXPECT_EQ(answer.substr(9, 3), "503") << answer;
    EXPECT_NE(answer.find("Retry-After: 1"), std::string::npos);
    EXPECT_TRUE(wait_until([&] { return http(socket, request).substr(9, 3) == "200"; })) << "it may be sent again";
    EXPECT_TRUE(wait_until([&] { return peer.heard().size() >= 24; }));
    EXPECT_EQ(peer.heard().size(), 24u);
}

}    // namespace
}    // namespace control_link_tests
