// The Foxglove WebSocket protocol over a whole gateway, with correct and faulty clients.
#include <support/controlled_gateway.hpp>
#include <support/process.hpp>
#include <support/udp_peer.hpp>

#include <config/difference.hpp>
#include <foxglove/foxglove_messages.hpp>

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace foxglove_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;
using Kind = anogate::http::WebSocket::Kind;
using anogate::http::Field;

const Bytes euler = frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
const Bytes wind = frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});
const std::vector<Field> offers{{"Sec-WebSocket-Protocol", "foxglove.websocket.v1"}};

/// A client that stores everything it receives.
class Plotter {
public:
    explicit Plotter(ControlledGateway& gateway, const std::string& target = "/", const std::vector<Field>& headers = offers)
        : message_client{gateway, target, headers} {}

    std::vector<json> said(const std::string& op) const {
        std::vector<json> all;
        for (const std::string& text : message_client.texts())
            if (json one = json::parse(text); one.at("op") == op) all.push_back(std::move(one));
        return all;
    }
    /// The channel of this topic; null: it was not advertised.
    json channel(const std::string& topic) const {
        for (const json& message : said("advertise"))
            for (const json& one : message.at("channels"))
                if (one.at("topic") == topic) return one;
        return nullptr;
    }
    void send(const json& message) { message_client.send(message.dump(), Kind::text); }
    void subscribe(unsigned id, const json& channel) {
        send({{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel.at("id")}}}}});
    }
    std::size_t shown(unsigned id) const {
        std::size_t count = 0;
        const std::string head = anogate::foxglove::message_data(id, 0, "").substr(0, 5);
        for (const std::string& message : message_client.messages())
            if (message.starts_with(head)) ++count;
        return count;
    }

    MessageClient message_client;
};

class Foxglove : public testing::Test {
protected:
    bool until(const std::function<bool()>& holds) { return gateway.gateway.until(holds); }
    bool until_told(const Plotter& plotter, const std::string& topic) {
        return until([&] {
            const bool is_there = !plotter.channel(topic).is_null();
            if (!is_there) send(euler);
            return is_there;
        });
    }
    void send(const Bytes& bytes) { a.send(gateway.gateway.port("a"), bytes); }
    bool until_in(std::size_t count) {
        return until([&] { return gateway.gateway.count("a", "frames_in") == count; });
    }
    /// The messages of a client are handled in the next turns of the loop.
    bool until_heard(Plotter& plotter) {
        const std::string id = "heard " + std::to_string(++questions_);
        plotter.send({{"op", "getParameters"}, {"id", id}});
        std::size_t looked_at = plotter.message_client.texts().size();
        bool is_answered = false;
        until([&] {
            for (; looked_at < plotter.message_client.texts().size() && !is_answered; ++looked_at)
                is_answered = plotter.message_client.texts()[looked_at].find('"' + id + '"') != std::string::npos;
            return is_answered;
        });
        gateway.gateway.run_for(20ms);    // filters change after that
        return is_answered;
    }

    UdpPeer a;
    ControlledGateway gateway{{a.link("a")}};

private:
    int questions_ = 0;
};

TEST_F(Foxglove, a_client_of_the_subprotocol_at_the_root_path_receives_server_info_and_channels) {
    Plotter plotter{gateway};
    ASSERT_TRUE(until([&] { return plotter.said("advertise").size() == 1; }));
    EXPECT_EQ(json::parse(plotter.message_client.texts().front()).at("op"), "serverInfo");
    EXPECT_EQ(plotter.channel("/anogate/frames").at("schemaName"), "ano_msgs/msg/RecordedFrame");
    send(euler);
    ASSERT_TRUE(until([&] { return !plotter.channel("/a/device_220/euler").is_null(); }));
    const json channel = plotter.channel("/a/device_220/euler");
    EXPECT_EQ(channel.at("encoding"), "cdr");
    EXPECT_EQ(channel.at("schemaEncoding"), "ros2msg");
    EXPECT_TRUE(plotter.message_client.messages().empty()) << "nothing is subscribed";
}

TEST_F(Foxglove, only_subscribed_channels_are_sent) {
    Plotter plotter{gateway};
    ASSERT_TRUE(until_told(plotter, "/a/device_220/euler"));
    send(wind);
    ASSERT_TRUE(until([&] { return !plotter.channel("/a/device_221/wind").is_null(); }));
    plotter.subscribe(7, plotter.channel("/a/device_220/euler"));
    ASSERT_TRUE(until_heard(plotter));
    for (int i = 0; i < 3; ++i) send(euler + wind);
    ASSERT_TRUE(until([&] { return plotter.shown(7) == 3; })) << plotter.shown(7);
    EXPECT_EQ(plotter.message_client.messages().size(), 3u);
    plotter.send({{"op", "unsubscribe"}, {"subscriptionIds", {7}}});
    ASSERT_TRUE(until_heard(plotter));
    send(euler);
    gateway.gateway.run_for(100ms);
    EXPECT_EQ(plotter.message_client.messages().size(), 3u);
    EXPECT_TRUE(plotter.said("status").empty());
}

TEST_F(Foxglove, channels_of_a_removed_link_are_unadvertised_even_without_new_frames) {
    Plotter plotter{gateway}, other{gateway, "/", {{"Sec-WebSocket-Protocol", "foxglove.sdk.v1"}}};
    ASSERT_TRUE(until_told(plotter, "/a/device_220/euler") && until_told(other, "/a/device_220/euler"));
    anogate::Gateway& running = gateway.gateway.gateway();
    anogate::Settings settings = running.settings();
    settings.links.clear();
    bool is_changed = false;
    running.change(settings, anogate::difference(running.settings(), settings), 0ms, [&] { is_changed = true; });
    ASSERT_TRUE(until([&] { return is_changed && !plotter.said("unadvertise").empty() && !other.said("unadvertise").empty(); }));
    const json gone = plotter.said("unadvertise").front().at("channelIds");
    EXPECT_NE(std::find(gone.begin(), gone.end(), plotter.channel("/a/device_220/euler").at("id")), gone.end()) << gone;
    EXPECT_EQ(std::find(gone.begin(), gone.end(), plotter.channel("/anogate/frames").at("id")), gone.end()) << gone;
    Plotter later{gateway};
    ASSERT_TRUE(until([&] { return !later.said("advertise").empty(); }));
    ASSERT_TRUE(until_heard(later));
    EXPECT_TRUE(later.channel("/a/device_220/euler").is_null());
}

TEST_F(Foxglove, a_second_subscription_loses_no_messages_of_the_first) {
    Plotter plotter{gateway};
    ASSERT_TRUE(until_told(plotter, "/a/device_220/euler"));
    send(wind);
    ASSERT_TRUE(until([&] { return !plotter.channel("/a/device_221/wind").is_null(); }));
    plotter.subscribe(1, plotter.channel("/a/device_220/euler"));
    ASSERT_TRUE(until_heard(plotter));
    std::size_t sent = 0;
    for (unsigned i = 0; i < 20; ++i) {
        for (int n = 0; n < 10; ++n, ++sent) send(euler);
        if (i % 2 == 0) plotter.subscribe(2, plotter.channel("/a/device_221/wind"));
        else plotter.send({{"op", "unsubscribe"}, {"subscriptionIds", {2}}});
        gateway.gateway.run_for(3ms);    // within the interval of a batch
    }
    EXPECT_TRUE(until([&] { return plotter.shown(1) == sent; })) << plotter.shown(1) << " of " << sent;
}

TEST_F(Foxglove, frames_are_sent_with_their_cause_whether_forwarded_or_dropped) {
    Plotter plotter{gateway};
    ASSERT_TRUE(until([&] { return !plotter.channel("/anogate/frames").is_null(); }));
    plotter.subscribe(3, plotter.channel("/anogate/frames"));
    ASSERT_TRUE(until_heard(plotter));
    send(frame(0xDC, 0x00, 0x03, {1}));    // to 0x00, which has no receiver
    EXPECT_TRUE(until([&] { return plotter.shown(3) == 2; }));
    EXPECT_NE(plotter.message_client.messages().back().find("no_route"), std::string::npos);
}

TEST_F(Foxglove, messages_are_json_if_requested) {
    Plotter plotter{gateway, "/?encoding=json"};
    ASSERT_TRUE(until_told(plotter, "/a/device_220/euler"));
    const json channel = plotter.channel("/a/device_220/euler");
    EXPECT_EQ(channel.at("encoding"), "json");
    EXPECT_EQ(channel.at("schemaEncoding"), "jsonschema");
    plotter.subscribe(0, channel);
    ASSERT_TRUE(until_heard(plotter));
    send(euler);
    ASSERT_TRUE(until([&] { return plotter.shown(0) == 1; }));
    EXPECT_EQ(json::parse(plotter.message_client.messages().front().substr(13)).at("rol"), 1.23);
    Plotter wrong{gateway, "/foxglove?encoding=protobuf"};
    ASSERT_TRUE(until([&] { return wrong.message_client.ended.has_value(); }));
    EXPECT_EQ(wrong.message_client.ended->answer.status, 400u);
    EXPECT_NE(wrong.message_client.ended->answer.body.find("'encoding' must be cdr or json, not 'protobuf'"), std::string::npos);
}

TEST_F(Foxglove, the_path_foxglove_requires_the_subprotocol) {
    Plotter plotter{gateway, "/foxglove"}, without{gateway, "/foxglove", {}};
    EXPECT_TRUE(until([&] { return !plotter.said("serverInfo").empty(); }));
    ASSERT_TRUE(until([&] { return without.message_client.ended.has_value(); }));
    EXPECT_EQ(without.message_client.ended->answer.status, 400u);
    EXPECT_NE(without.message_client.ended->answer.body.find("needs the subprotocol foxglove.sdk.v1"), std::string::npos);
    EXPECT_EQ(gateway.ask("GET", "/foxglove").status, 426u);
}

TEST_F(Foxglove, frames_are_not_observed_after_the_last_client_disconnects) {
    const auto is_watched = [&] { return gateway.gateway.gateway().forwarder().is_observed(); };
    EXPECT_FALSE(is_watched());
    Plotter one{gateway}, two{gateway};
    ASSERT_TRUE(until_told(one, "/a/device_220/euler"));
    one.subscribe(1, one.channel("/a/device_220/euler"));
    ASSERT_TRUE(until_heard(one));
    one.message_client.leave();
    gateway.gateway.run_for(50ms);
    EXPECT_TRUE(is_watched());
    two.message_client.leave();
    EXPECT_TRUE(until([&] { return !is_watched(); }));
    Plotter again{gateway};
    ASSERT_TRUE(until_told(again, "/a/device_220/euler"));
}

TEST_F(Foxglove, a_later_client_receives_the_channels_found_earlier) {
    Plotter first{gateway};
    ASSERT_TRUE(until_told(first, "/a/device_220/euler"));
    Plotter second{gateway};
    EXPECT_TRUE(until([&] { return !second.channel("/a/device_220/euler").is_null(); }));
}

TEST_F(Foxglove, invalid_messages_are_answered_and_too_large_ones_close_the_connection) {
    Plotter plotter{gateway};
    ASSERT_TRUE(until([&] { return plotter.message_client.is_open(); }));
    plotter.message_client.send("nonsense", Kind::text);
    plotter.message_client.send({'\1', '\2'}, Kind::binary);
    plotter.send({{"op", "setParameters"}, {"parameters", {{{"name", "a/220/X"}, {"value", 1}}}}});
    ASSERT_TRUE(until([&] { return plotter.said("status").size() == 3; }));
    for (const json& status : plotter.said("status")) EXPECT_EQ(status.at("level"), 2) << status;
    for (unsigned i = 0; i < 2000; ++i) {
        plotter.send({{"op", "subscribe"}, {"subscriptions", {{{"id", i}, {"channelId", 999}}}}});
        if (i % 200 == 0) gateway.gateway.run_for(1ms);
    }
    ASSERT_TRUE(until_heard(plotter));
    EXPECT_GT(plotter.said("status").size(), 3u);
    plotter.message_client.send(std::string(65 * 1024, ' '), Kind::text);
    EXPECT_TRUE(until([&] { return plotter.message_client.ended.has_value(); }));
    EXPECT_TRUE(gateway.gateway.counters_add_up());
}

// A client's frames, made by hand: this client stops reading.
std::string masked(const std::string& text) {
    std::string bytes{static_cast<char>(0x81), static_cast<char>(0x80 | text.size()), '\0', '\0', '\0', '\0'};
    return bytes + text;
}

TEST_F(Foxglove, a_slow_client_delays_no_other_one_and_receives_a_report_of_lost_messages) {
    Plotter awake{gateway};
    const int sleeper = connect_unix(gateway.path);
    const std::string begin =
        "GET / HTTP/1.1\r\nHost: x\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Protocol: foxglove.sdk.v1, foxglove.websocket.v1\r\n\r\n" +
        masked(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]})");
    ASSERT_EQ(::send(sleeper, begin.data(), begin.size(), MSG_NOSIGNAL), static_cast<ssize_t>(begin.size()));
    ASSERT_TRUE(until([&] { return !awake.channel("/anogate/frames").is_null(); }));
    awake.subscribe(1, awake.channel("/anogate/frames"));
    ASSERT_TRUE(until_heard(awake));
    gateway.gateway.run_for(100ms);
    constexpr std::size_t count = 1200;
    const Bytes big = frame(0xDC, 0x00, 0xF1, Bytes(4000, 7));
    for (std::size_t i = 0; i < count; ++i) {
        send(big);
        ASSERT_TRUE(until_in(i + 1));
        if (i % 20 > 0) continue;
        ASSERT_TRUE(until([&] { return awake.message_client.messages().size() == 2 * (i + 1); })) << "who reads misses nothing";
    }
    EXPECT_TRUE(awake.said("status").empty());
    std::string heard;
    EXPECT_TRUE(until([&] {
        char buffer[65536];
        for (ssize_t n; (n = ::recv(sleeper, buffer, sizeof buffer, MSG_DONTWAIT)) > 0;)
            heard.append(buffer, static_cast<std::size_t>(n));
        return heard.find("were dropped: the client reads too slowly: flexible1 ") != std::string::npos;
    }));
    EXPECT_TRUE(heard.starts_with("HTTP/1.1 101"));
    EXPECT_NE(heard.find("Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n"), std::string::npos) << heard.substr(0, 300);
    ::close(sleeper);
}

class FoxgloveParameters : public testing::Test {
protected:
    bool until(const std::function<bool()>& holds) { return gateway.gateway.until(holds); }
    void SetUp() override {
        ASSERT_TRUE(until([&] { return !plotter.said("advertise").empty() && !gateway.gateway.route("0xDC").is_null(); }));
    }
    /// The answer to a question; null: there was none.
    json answer(const json& names, const std::string& id) {
        plotter.send({{"op", "getParameters"}, {"parameterNames", names}, {"id", id}});
        json found;
        EXPECT_TRUE(until([&] {
            for (const json& one : plotter.said("parameterValues"))
                if (one.value("id", "") == id) found = one.at("parameters");
            return !found.is_null();
        }));
        return found;
    }

    ControlledGateway gateway{{"sim:fc,name=fc"}};
    Plotter plotter{gateway};
};

TEST_F(FoxgloveParameters, are_read_from_devices_by_name_and_listed_from_then_on) {
    EXPECT_EQ(answer(json::array(), "before"), json::array()) << "nobody read any";
    const json values = answer({"fc/220/SIM_SWAY", "fc/220/SIM_MODE", "fc/220/NONE", "fc/9/SIM_MODE"}, "some");
    ASSERT_EQ(values.size(), 2u) << values;
    EXPECT_EQ(values[0].at("name"), "fc/220/SIM_SWAY");
    EXPECT_EQ(values[0].at("type"), "float64");
    EXPECT_EQ(values[1].at("name"), "fc/220/SIM_MODE");
    EXPECT_TRUE(values[1].at("value").is_number_integer());
    EXPECT_EQ(plotter.said("status").size(), 1u) << "9 is not heard";
    EXPECT_EQ(answer(json::array(), "behind").size(), 2u);
    Plotter another{gateway};
    ASSERT_TRUE(until([&] { return another.message_client.is_open(); }));
    another.send({{"op", "getParameters"}, {"parameterNames", json::array()}, {"id", "x"}});
    ASSERT_TRUE(until([&] { return !another.said("parameterValues").empty(); }));
    EXPECT_EQ(another.said("parameterValues").front().at("parameters").size(), 2u);
}

TEST_F(FoxgloveParameters, that_others_write_are_sent_to_subscribed_clients) {
    plotter.send({{"op", "subscribeParameterUpdates"}, {"parameterNames", {"fc/220/SIM_SWAY"}}});
    EXPECT_EQ(gateway.ask("PUT", "/devices/0xDC/parameters/SIM_SWAY", R"({"value": 12.5})").status, 200u);
    ASSERT_TRUE(until([&] { return !plotter.said("parameterValues").empty(); }));
    const json told = plotter.said("parameterValues").front();
    EXPECT_EQ(told.at("parameters"), json::parse(R"([{"name":"fc/220/SIM_SWAY","value":12.5,"type":"float64"}])"));
    EXPECT_FALSE(told.contains("id"));
}

TEST_F(FoxgloveParameters, are_not_written) {
    const json before = answer({"fc/220/SIM_SWAY"}, "before");
    plotter.send({{"op", "setParameters"}, {"parameters", {{{"name", "fc/220/SIM_SWAY"}, {"value", 77}}}}, {"id", "x"}});
    ASSERT_TRUE(until([&] { return !plotter.said("status").empty(); }));
    EXPECT_EQ(answer({"fc/220/SIM_SWAY"}, "behind"), before);
}

TEST_F(FoxgloveParameters, that_a_disconnected_client_requested_cause_no_harm) {
    for (int i = 0; i < 10; ++i)
        plotter.send({{"op", "getParameters"}, {"parameterNames", {"fc/220/SIM_SWAY"}}, {"id", std::to_string(i)}});
    gateway.gateway.run_for(1ms);
    plotter.message_client.leave();
    Plotter another{gateway};
    ASSERT_TRUE(until([&] { return another.message_client.is_open(); }));
    gateway.gateway.run_for(300ms);
    EXPECT_TRUE(another.said("parameterValues").empty());
}

// --- Over the network

const std::string looks = "view-token-0123456789", acts = "control-token-0123456789";

class FoxgloveAccess : public testing::Test {
protected:
    void start() {
        daemon.emplace(ANOGATED, dir / "control.sock", std::vector<std::string>{"--config", config});
        ASSERT_TRUE(daemon->until_answers()) << daemon->output();
        port = daemon->http_port();
        ASSERT_NE(port, 0) << daemon->output();
    }
    void SetUp() override { start(); }
    /// The beginning of the answer to a client that offers the subprotocol, up to and including the first message. Sent through a
    /// proxy, so that a token is needed whichever user runs the test.
    std::string joined(const std::string& target, const std::string& more = {}, const std::string& host = "localhost",
                       const std::string& subprotocol = "foxglove.websocket.v1") const {
        const int fd = connect_tcp(port);
        const std::string request = "GET " + target + " HTTP/1.1\r\nHost: " + host +
                                    "\r\nVia: 1.1 test\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                                    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                                    "Sec-WebSocket-Protocol: " +
                                    subprotocol + "\r\n" + more + "\r\n";
        EXPECT_EQ(::send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
        std::string answer;
        char buffer[4096];
        const auto is_whole = [&] {
            return answer.find("\"sessionId\"") != std::string::npos || answer.find("\"what\"") != std::string::npos ||
                   answer.find("\"routes\"") != std::string::npos;
        };
        for (ssize_t n; !is_whole() && (n = ::read(fd, buffer, sizeof buffer)) > 0;)
            answer.append(buffer, static_cast<std::size_t>(n));
        ::close(fd);
        return answer;
    }
    static std::string code_of(const std::string& answer) { return answer.size() > 12 ? answer.substr(9, 3) : answer; }

    TempDir dir;
    std::string tokens = [this] {
        const std::string file = dir.write("token", "view " + looks + "\ncontrol " + acts + "\n");
        std::filesystem::permissions(file, std::filesystem::perms{0600});
        return file;
    }();
    std::string config = dir.write(
        "anogate.json", R"({"links": ["udp-listen:127.0.0.1:0,name=ground"], "log": {"level": "trace"}, "control": {"http": )"
                        R"("127.0.0.1:0", "origins": ["https://app.foxglove.dev", "file://"], "token_file": ")" +
                            tokens + "\"}}");
    std::optional<Daemon> daemon;
    std::uint16_t port = 0;
};

TEST_F(FoxgloveAccess, accepts_a_token_in_the_query_or_in_a_header) {
    EXPECT_EQ(code_of(joined("/?token=" + looks)), "101");
    EXPECT_EQ(code_of(joined("/foxglove?token=" + acts + "&encoding=json")), "101");
    EXPECT_EQ(code_of(joined("/", "Authorization: Bearer " + looks + "\r\n")), "101");
    const std::string without = joined("/");
    EXPECT_EQ(code_of(without), "401");
    EXPECT_NE(without.find("Foxglove needs a token: ws://HOST:PORT/?token=TOKEN"), std::string::npos) << without;
    EXPECT_EQ(code_of(joined("/foxglove")), "401");
    EXPECT_EQ(code_of(joined("/frames?token=" + looks, {}, "localhost", "none")), "401") << "of another subprotocol";
    EXPECT_EQ(code_of(http(port, "GET /status?token=" + looks +
                                     " HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\nConnection: close\r\n\r\n")),
              "401");
}

TEST_F(FoxgloveAccess, blocks_clients_that_guess_tokens) {
    for (int i = 0; i < 10; ++i) EXPECT_EQ(code_of(joined("/?token=guess" + std::to_string(i))), "401");
    EXPECT_EQ(code_of(joined("/?token=guess")), "429");
    EXPECT_EQ(code_of(joined("/?token=" + looks)), "101") << "a right one is always taken";
}

TEST_F(FoxgloveAccess, rejects_other_host_names_and_origins_that_are_not_allowed) {
    EXPECT_EQ(code_of(joined("/?token=" + looks, {}, "evil.example")), "403") << "a name that was made to lead here";
    EXPECT_EQ(code_of(joined("/?token=" + looks, "Origin: https://evil.example\r\n")), "403");
    EXPECT_EQ(code_of(joined("/?token=" + looks, "Origin: null\r\n")), "403");
    EXPECT_EQ(code_of(joined("/?token=" + looks, "Origin: https://app.foxglove.dev\r\n")), "101");
    EXPECT_EQ(code_of(joined("/?token=" + looks, "Origin: file://\r\n")), "101");
}

TEST_F(FoxgloveAccess, never_returns_or_logs_a_token) {
    const std::vector<std::string> answers{
        joined("/?token=" + looks),          joined("/?token=wrong-" + looks),
        joined("/nothing?token=" + looks),   joined("/foxglove?encoding=" + looks.substr(0, 4) + "&token=" + looks),
        joined("/?token=" + looks + "&%zz"), joined("/frames?format=binary&token=" + looks)};
    for (const std::string& answer : answers) EXPECT_EQ(answer.find(looks), std::string::npos) << answer;
    for (const std::string path : {"/status", "/metrics", "/"})
        EXPECT_EQ(http(dir / "control.sock", "GET " + path + " HTTP/1.0\r\n\r\n").find(looks), std::string::npos) << path;
    EXPECT_EQ(daemon->output().find(looks), std::string::npos) << daemon->output();
}

TEST_F(FoxgloveAccess, of_a_restarted_gateway_has_another_session_id) {
    const auto session = [&] {
        const std::string answer = joined("/?token=" + looks);
        const auto begin = answer.find("\"sessionId\":\"");
        return begin == std::string::npos ? answer : answer.substr(begin, answer.find('}', begin) - begin);
    };
    const std::string before = session();
    EXPECT_EQ(session(), before);
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(), 0);
    start();
    EXPECT_NE(session(), before);
}

}    // namespace
}    // namespace foxglove_tests
