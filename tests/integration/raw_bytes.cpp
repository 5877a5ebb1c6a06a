// The raw bytes of links: GET /links/L/raw, `anoctl terminal`, and pauses between frames.
#include <ano/hex.hpp>
#include <link/raw_port.hpp>
#include <link/serial/serial_settings.hpp>
#include <support/controlled_gateway.hpp>
#include <support/files.hpp>
#include <support/http.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/tcp_peer.hpp>
#include <support/udp_peer.hpp>
#include <support/v7_vectors.hpp>
#include <sys/unique_fd.hpp>

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace raw_bytes_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::http::Field;
using nlohmann::json;

Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

// The bytes that passed in one direction, without their times.
Bytes passed(const MessageClient& message_client, char direction) {
    Bytes all;
    for (const std::string& message : message_client.messages())
        if (message.at(0) == direction) all.insert(all.end(), message.begin() + 9, message.end());
    return all;
}

bool contains(const Bytes& bytes, std::string_view text) {
    return std::string_view{reinterpret_cast<const char*>(bytes.data()), bytes.size()}.find(text) != std::string_view::npos;
}

const Bytes telemetry = frame(0xDC, 0xFF, 0x03, {1, 2, 3, 4, 5, 6, 7});
const Bytes command = frame(0xFE, 0xDC, 0xC0, {1, 2, 3});

class RawBytes : public testing::Test {
protected:
    RawBytes() { EXPECT_TRUE(gateway.gateway.until_up("fc")); }
    bool until(const std::function<bool()>& holds) { return gateway.gateway.until(holds); }
    bool until_begins(MessageClient& message_client) {
        return until([&] { return !message_client.texts().empty(); });
    }
    void send_command() { station.send(gateway.gateway.port("ground"), command); }
    std::uint64_t count(const std::string& counter) { return gateway.gateway.count("fc", counter); }

    const TempDir dir;
    PtyDevice device{dir / "fc"};
    UdpPeer station;
    ControlledGateway gateway{{"serial:" + (dir / "fc") + ",pace=off,encoding=gbk", "udp-listen:127.0.0.1:0,name=ground"}};
};

TEST_F(RawBytes, pass_in_both_directions_while_frames_are_forwarded_as_usual) {
    MessageClient raw{gateway, "/links/fc/raw"};
    ASSERT_TRUE(until_begins(raw));
    EXPECT_EQ(json::parse(raw.texts().at(0)),
              (json{{"link", "fc"}, {"kind", "serial"}, {"encoding", "gbk"}, {"exclusive", false}, {"may_send", true}}));
    device.write(bytes_of("boot\r\n"));
    device.write(telemetry);
    EXPECT_TRUE(until([&] { return passed(raw, '<') == bytes_of("boot\r\n") + telemetry; }));
    EXPECT_TRUE(until([&] { return count("frames_in") == 1; }));
    raw.send(bytes_of("AT\r\n"));
    EXPECT_TRUE(until([&] { return device.heard() == bytes_of("AT\r\n"); }));
    send_command();
    EXPECT_TRUE(until([&] { return device.heard() == bytes_of("AT\r\n") + command; }));
    EXPECT_TRUE(until([&] { return passed(raw, '>') == bytes_of("AT\r\n") + command; }));
    const std::string first = raw.messages().at(0);
    std::uint64_t ns = 0;
    for (std::size_t i = 8; i > 0; --i) ns = ns << 8 | static_cast<std::uint8_t>(first[i]);
    EXPECT_GT(ns, 1'600'000'000'000'000'000u);
}

TEST_F(RawBytes, in_exclusive_use_no_frame_is_sent_on_the_link_until_the_client_disconnects) {
    {
        MessageClient raw{gateway, "/links/fc/raw?exclusive"};
        ASSERT_TRUE(until_begins(raw));
        send_command();
        EXPECT_TRUE(until([&] { return count("denied_out") == 1; }));
        EXPECT_NE(gateway.ask("GET", "/status").body.find(R"("hint_id":"exclusive_use")"), std::string::npos);
        raw.send(bytes_of("AT\r\n"));
        EXPECT_TRUE(until([&] { return device.heard() == bytes_of("AT\r\n"); }));
        device.write(telemetry);
        EXPECT_TRUE(until([&] { return count("frames_in") == 1; })) << "what comes is forwarded";
        EXPECT_EQ(gateway.ask("GET", "/links/fc/raw?exclusive").status, 426u) << "no WebSocket";
        MessageClient second{gateway, "/links/fc/raw?exclusive"};
        EXPECT_TRUE(until([&] { return second.ended.has_value(); }));
        EXPECT_EQ(second.ended->answer.status, 409u);
        MessageClient looks{gateway, "/links/fc/raw"};
        EXPECT_TRUE(until_begins(looks)) << "others may look";
    }    // its connection ends without a closing message
    EXPECT_TRUE(until([&] {
        send_command();
        return device.heard().size() > 4;
    }));
    EXPECT_TRUE(gateway.gateway.counters_add_up());
}

TEST_F(RawBytes, are_not_in_exclusive_use_if_the_client_does_not_want_that) {
    MessageClient raw{gateway, "/links/fc/raw?exclusive=no"}, exclusive{gateway, "/links/fc/raw?exclusive=yes"};
    ASSERT_TRUE(until_begins(raw) && until_begins(exclusive));
    EXPECT_EQ(json::parse(raw.texts().at(0)).at("exclusive"), false);
    EXPECT_EQ(json::parse(exclusive.texts().at(0)).at("exclusive"), true);
    MessageClient neither{gateway, "/links/fc/raw?exclusive=false"};
    EXPECT_TRUE(until([&] { return neither.ended.has_value(); }));
    EXPECT_EQ(neither.ended->answer.status, 400u);
    EXPECT_NE(neither.ended->answer.body.find("exclusive='false' is neither yes nor no"), std::string::npos);
}

// As after a loss of the network: it neither closes its connection nor answers a ping.
TEST_F(RawBytes, in_exclusive_use_by_a_client_that_is_gone_are_free_again_within_five_seconds) {
    const anogate::UniqueFd lost{connect_unix(gateway.path)};
    const std::string request =
        "GET /links/fc/raw?exclusive HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
    ASSERT_EQ(::write(lost.get(), request.data(), request.size()), static_cast<ssize_t>(request.size()));
    ASSERT_TRUE(
        wait_until([&] { return gateway.ask("GET", "/status").body.find(R"("hint_id":"exclusive_use")") != std::string::npos; }));
    const auto began = std::chrono::steady_clock::now();
    EXPECT_TRUE(until([&] {
        send_command();
        return !device.heard().empty();
    }));
    EXPECT_LT(std::chrono::steady_clock::now() - began, 5s);
}

TEST_F(RawBytes, in_exclusive_use_by_a_client_that_answers_pings_stay_so) {
    MessageClient raw{gateway, "/links/fc/raw?exclusive"};
    ASSERT_TRUE(until_begins(raw));
    gateway.gateway.run_for(5s);
    EXPECT_FALSE(raw.ended.has_value());
    send_command();
    EXPECT_TRUE(until([&] { return count("denied_out") == 1; }));
    EXPECT_TRUE(device.heard().empty()) << "the pings are only for the client";
}

TEST_F(RawBytes, are_rejected_for_other_link_kinds) {
    for (const auto& [link, status] : {std::pair{"ground", 409u}, {"nobody", 404u}}) {
        MessageClient raw{gateway, std::string{"/links/"} + link + "/raw"};
        EXPECT_TRUE(until([&] { return raw.ended.has_value(); }));
        EXPECT_EQ(raw.ended->answer.status, status) << link;
        if (status == 409u) {
            EXPECT_NE(raw.ended->answer.body.find("only those of serial, hid, pty, udp, tcp and sim links"), std::string::npos);
        } else {
            EXPECT_NE(raw.ended->answer.body.find("unknown link 'nobody'; links: "), std::string::npos) << raw.ended->answer.body;
        }
    }
}

TEST_F(RawBytes, for_a_link_that_is_down_are_not_sent_and_the_client_is_notified) {
    MessageClient raw{gateway, "/links/fc/raw"};
    ASSERT_TRUE(until_begins(raw));
    device.unplug();
    ASSERT_TRUE(gateway.gateway.until_waiting("fc"));
    raw.send(bytes_of("AT\r\n"));
    EXPECT_TRUE(until([&] { return raw.texts().size() == 2; }));
    EXPECT_NE(raw.texts().at(1).find("not sent: the link is down"), std::string::npos);
    raw.send("AT", anogate::http::WebSocket::Kind::text);
    EXPECT_TRUE(until([&] { return raw.texts().size() == 3; }));
    device.plug();
    ASSERT_TRUE(gateway.gateway.until_up("fc"));
    device.write(bytes_of("again\n"));
    EXPECT_TRUE(until([&] { return passed(raw, '<') == bytes_of("again\n"); }));
}

// A client that reads nothing: traffic continues, the loss is bounded, and reported when it reads again.
TEST(RawBytesOfASlowClient, are_omitted_and_counted_while_frames_are_forwarded) {
    const TempDir dir;
    PtyDevice device{dir / "fc"};
    UdpPeer station;
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"serial:" + (dir / "fc"), station.link("ground")}};
    ASSERT_TRUE(daemon.until_up("fc"));
    const auto never_ending_input = [] {
        int ends[2];
        if (::pipe(ends) == 0) ::dup2(ends[0], STDIN_FILENO);
    };
    Process terminal{ANOCTL, {"terminal", "fc", "--hex", "--control", socket}, {}, never_ending_input};
    ASSERT_TRUE(terminal.until_says("press Enter to send a line"));
    terminal.signal(SIGSTOP);
    Bytes many;
    while (many.size() < 4000) many = many + telemetry;
    std::uint64_t sent = 0;
    while (sent < 4'000'000) {
        const std::size_t n = device.write(many);
        sent += n;
        if (n < many.size()) {
            station.heard();
            std::this_thread::sleep_for(1ms);
        }
    }
    EXPECT_TRUE(daemon.until([&](const json&) { return daemon.count("fc", "bytes_in") == sent; })) << "all is read";
    terminal.signal(SIGCONT);
    device.write(bytes_of("end of it\n"));
    EXPECT_TRUE(terminal.until_says("not shown: this terminal reads too slowly"));
    terminal.signal(SIGINT);
    EXPECT_EQ(terminal.wait(), 0);
}

TEST(Terminal, ends_when_all_input_is_sent) {
    const TempDir dir;
    PtyDevice device{dir / "fc"};
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"serial:" + (dir / "fc")}};
    ASSERT_TRUE(daemon.until_up("fc"));
    Shell terminal{"printf 'AT\\nAT+1\\n' | " ANOCTL " terminal fc --end lf --control " + socket};
    EXPECT_EQ(terminal.wait(), 0) << terminal.output();
    EXPECT_TRUE(wait_until([&] { return device.heard() == bytes_of("AT\nAT+1\n"); }));
}

TEST(Terminal, shows_the_v7_frames_of_a_link_in_both_directions) {
    const TempDir dir;
    PtyDevice device{dir / "imu"};
    UdpPeer station;
    const std::string socket = dir / "control.sock";
    Daemon daemon{
        ANOGATED, socket, {"serial:" + (dir / "imu") + ",protocol=v7,v7_device=0xDD", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("imu"));
    Process terminal{ANOCTL, {"terminal", "imu", "--v7", "--json", "--control", socket}};
    ASSERT_TRUE(terminal.until_says("shows the V7 frames"));
    device.write(Bytes{0x00, 0xAA} + v7_frame(0xAF, 0x03, {1, 0, 2, 0, 3, 0, 1}));
    ASSERT_TRUE(terminal.until_says("\"direction\":\"in\""));
    EXPECT_TRUE(terminal.until_says("\"to\":175,\"id\":3,\"name\":\"euler\"")) << terminal.output();
    station.send(daemon.port("ground"), frame(0xFE, 0xDD, 0xC0, {0x10, 0, 1}));
    EXPECT_TRUE(terminal.until_says("\"direction\":\"out\"")) << terminal.output();
    EXPECT_TRUE(terminal.until_says("\"name\":\"command\"")) << terminal.output();
}

TEST(Terminal, shows_and_sends_the_bytes_of_a_tcp_link) {
    const TempDir dir;
    TcpListener listener;
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"tcp:" + listener.address() + ",name=radio"}};
    TcpPeer peer;
    ASSERT_TRUE(wait_until([&] { return listener.accept(peer); }));
    ASSERT_TRUE(daemon.until_up("radio"));
    Shell terminal{"(echo AT; sleep 100) | exec " ANOCTL " terminal radio --end lf --control " + socket};
    EXPECT_TRUE(wait_until([&] { return contains(peer.heard(), "AT\n"); }));
    peer.send(bytes_of("OK\n"));
    EXPECT_TRUE(terminal.until_says(" < OK")) << terminal.output();
    terminal.end();
}

TEST(Terminal, shows_and_sends_the_bytes_of_a_sim_link) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"sim:fc,name=fc"}};
    ASSERT_TRUE(daemon.until_up("fc"));
    // 0xE0 1: how many parameters
    const Bytes question = frame(0xFE, 0xDC, 0xE0, {1, 0, 0});
    Shell terminal{"(echo " + ano::hex(question) + "; sleep 100) | exec " ANOCTL " terminal fc --hex --control " + socket};
    EXPECT_TRUE(terminal.until_says(" > AB FE DC E0 03 00 01 00 00")) << terminal.output();
    EXPECT_TRUE(terminal.until_says("AB DC FE E0 03 00")) << terminal.output();
    terminal.end();
}

TEST(Terminal, captures_the_v7_frames_of_a_link_for_wireshark) {
    const TempDir dir;
    PtyDevice device{dir / "imu"};
    UdpPeer station;
    const std::string socket = dir / "control.sock", capture = dir / "imu.pcapng";
    Daemon daemon{
        ANOGATED, socket, {"serial:" + (dir / "imu") + ",protocol=v7,v7_device=0xDD", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("imu"));
    Process terminal{ANOCTL, {"terminal", "imu", "--pcapng", capture, "--control", socket}};
    ASSERT_TRUE(terminal.until_says("writes the V7 frames to")) << terminal.output();
    const Bytes euler = v7_frame(0xAF, 0x03, {1, 0, 2, 0, 3, 0, 1});
    device.write(Bytes{0x00, 0xAA} + euler);
    station.send(daemon.port("ground"), frame(0xFE, 0xDD, 0xC0, {0x10, 0, 1}));
    ASSERT_TRUE(wait_until([&] { return !device.heard().empty(); }));
    const auto captured = [&] { return support::file_text(capture); };
    const auto contains = [&](const Bytes& bytes) {
        return captured().find(std::string{bytes.begin(), bytes.end()}) != std::string::npos;
    };
    EXPECT_TRUE(wait_until([&] { return contains(euler) && contains(device.heard()); }));
    terminal.signal(SIGTERM);
    EXPECT_EQ(terminal.wait(), 0);
    EXPECT_EQ(captured().find("dropped"), std::string::npos);
    Process again{ANOCTL, {"terminal", "imu", "--pcapng", capture, "--control", socket}};
    EXPECT_EQ(again.wait(), 2);
    EXPECT_NE(again.output().find("already exists; use --force"), std::string::npos) << again.output();
}

TEST(Terminal, escapes_received_lines_sends_lines_and_releases_the_link_when_it_is_killed) {
    const TempDir dir;
    PtyDevice device{dir / "radio"};
    UdpPeer station;
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"serial:" + (dir / "radio") + ",encoding=gbk", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("radio"));
    Shell terminal{"(printf 'AT+飞\\r\\n'; sleep 100) | exec " ANOCTL " terminal radio --exclusive --end cr --control " + socket};
    ASSERT_TRUE(terminal.until_says("no frames are forwarded to it")) << terminal.output();
    EXPECT_TRUE(wait_until([&] { return device.heard() == bytes_of("AT+\xB7\xC9\r"); }));
    EXPECT_TRUE(terminal.until_says(" > AT+飞\n")) << terminal.output();
    device.write(bytes_of("OK \x1b[2J\xC6\xF4\r\n"));
    EXPECT_TRUE(terminal.until_says(" < OK \\x1B[2J启\n")) << terminal.output();
    station.send(daemon.port("ground"), command);
    EXPECT_TRUE(daemon.until([&](const json&) { return daemon.count("radio", "denied_out") == 1; }));
    terminal.end();
    EXPECT_TRUE(wait_until([&] {
        station.send(daemon.port("ground"), command);
        return device.heard().size() > 6;
    })) << "its client was killed";
    Process unknown{ANOCTL, {"terminal", "ground", "--control", socket}};
    EXPECT_EQ(unknown.wait(), 1);
    EXPECT_NE(unknown.output().find("only those of serial, hid, pty, udp, tcp and sim links"), std::string::npos)
        << unknown.output();
}

// The time at which each frame was written, reported by the link itself: a device that is read late proves nothing.
class Times final : public anogate::RawTap {
public:
    void received(std::span<const std::uint8_t>) override {}
    void sent(std::span<const std::uint8_t> bytes) override {
        at.push_back(anogate::Clock::now());
        sizes.push_back(bytes.size());
    }
    std::vector<anogate::TimePoint> at;
    std::vector<std::size_t> sizes;
};

TEST(Gap, frames_are_sent_one_by_one_with_a_pause_after_each_on_serial_pty_and_udp) {
    const TempDir dir;
    PtyDevice device{dir / "fc"};
    UdpPeer station, peer;
    RunningGateway gateway{settings_of_texts(
        {"serial:" + (dir / "fc") + ",baud=115200,gap=15ms", "pty:" + (dir / "app") + ",gap=15ms",
         "udp:127.0.0.1:" + std::to_string(peer.port()) + ",name=radio,gap=15ms", "udp-listen:127.0.0.1:0,name=ground"})};
    int app = -1;
    EXPECT_TRUE(gateway.until([&] {
        if (app < 0) app = ::open((dir / "app").c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
        return app >= 0;
    }));
    ASSERT_TRUE(gateway.until_up("fc") && gateway.until_up("app") && gateway.until_up("radio"));
    std::vector<Times> times(3);
    for (std::size_t i = 0; i < times.size(); ++i)
        gateway.gateway().links().at(i).link->as<anogate::RawPort>()->set_tap(&times[i]);
    Bytes commands;
    for (std::uint8_t n = 0; n < 10; ++n) commands = commands + frame(0xFE, 0xDC, 0xC0, {n, 2, 3});
    station.send(gateway.port("ground"), commands);
    EXPECT_TRUE(gateway.until(
        [&] { return std::all_of(times.begin(), times.end(), [](const Times& of) { return of.at.size() == 10; }); }));
    for (const Times& of : times)
        for (std::size_t i = 0; i < of.at.size(); ++i) {
            EXPECT_EQ(of.sizes[i], 11u);
            if (i > 0) {
                EXPECT_GE(of.at[i] - of.at[i - 1], 15ms);
            }
        }
    EXPECT_GE(times[0].at.back() - times[0].at.front(), 9 * (15ms + 11 * 86us)) << "from the end of each frame on the line";
    EXPECT_EQ(device.heard(), commands);
    EXPECT_TRUE(gateway.until([&] { return peer.heard() == commands; }));
    for (const auto& state : gateway.gateway().links())
        if (auto* port = state.link->as<anogate::RawPort>()) port->set_tap(nullptr);
    ::close(app);
}

}    // namespace
}    // namespace raw_bytes_tests
