// Clients of GET /frames: WebSockets of both forms, and endless lines.
#include <support/controlled_gateway.hpp>
#include <support/process.hpp>
#include <support/udp_peer.hpp>

#include <gateway/frame_record.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace frames_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Direction;
using anogate::FrameRecord;
using anogate::http::Answer;
using nlohmann::json;

const Bytes euler = frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
const Bytes wind = frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});

struct Seen {
    std::map<std::string, std::size_t> count;    // "in", "out" and causes
    std::vector<Bytes> frames;
    bool is_whole = true;
};

/// The messages that a binary watcher received.
Seen seen(const MessageClient& message_client) {
    Seen result;
    for (const std::string& message : message_client.messages()) {
        std::string_view rest = message;
        while (const auto record = anogate::next_record(rest)) {
            const bool is_dropped = record->direction == Direction::dropped;
            ++result.count[std::string{is_dropped ? anogate::frame_causes()[record->cause] : text(record->direction)}];
            result.frames.emplace_back(record->frame.bytes().begin(), record->frame.bytes().end());
        }
        result.is_whole = result.is_whole && rest.empty();
    }
    return result;
}

class Frames : public testing::Test {
protected:
    bool until_open(const MessageClient& message_client) {
        return gateway.gateway.until([&] { return message_client.is_open(); });
    }
    /// The first text contains the numbers: from then on it receives frames.
    bool until_watches(const MessageClient& message_client) {
        return gateway.gateway.until([&] { return !message_client.texts().empty(); });
    }
    bool until_seen(const MessageClient& message_client, std::size_t count) {
        return gateway.gateway.until([&] { return seen(message_client).frames.size() == count; });
    }
    void send(const Bytes& bytes) { a.send(gateway.gateway.port("a"), bytes); }
    bool until_in(std::size_t count) {
        return gateway.gateway.until([&] { return gateway.gateway.count("a", "frames_in") == count; });
    }

    UdpPeer a, b;
    ControlledGateway gateway{{a.link("a"), b.link("b")}};
};

TEST_F(Frames, binary_clients_receive_the_numbering_first_and_then_each_frame) {
    MessageClient message_client{gateway, "/frames?format=binary"};
    ASSERT_TRUE(until_watches(message_client));
    const json tables = json::parse(message_client.texts().front());
    EXPECT_EQ(tables.at("links"), (json{"a", "b"}));
    EXPECT_EQ(tables.at("channels").size(), 2u);
    EXPECT_EQ(tables.at("causes").at(0), nullptr);
    const auto before = std::chrono::system_clock::now().time_since_epoch();
    send(euler);
    ASSERT_TRUE(until_seen(message_client, 2));
    std::string_view rest = message_client.messages().front();
    const auto in = anogate::next_record(rest);
    ASSERT_TRUE(in);
    EXPECT_EQ(in->direction, Direction::in);
    EXPECT_EQ(tables.at("links").at(in->link), "a");
    EXPECT_NE(tables.at("channels").at(in->channel), nullptr);
    EXPECT_EQ(in->cause, 0);
    EXPECT_EQ(Bytes(in->frame.bytes().begin(), in->frame.bytes().end()), euler);
    const auto time = std::chrono::nanoseconds{in->time_ns};
    EXPECT_GT(time, before - 1s);
    EXPECT_LT(time, before + 60s);
    EXPECT_GT(in->boottime_ns, 0u);
    const Seen all = seen(message_client);
    EXPECT_EQ(all.count, (std::map<std::string, std::size_t>{{"in", 1}, {"out", 1}}));
    EXPECT_TRUE(all.is_whole);
    EXPECT_EQ(all.frames.at(1), euler);
}

TEST_F(Frames, that_a_client_receives_add_up_to_the_counters) {
    MessageClient message_client{gateway, "/frames?format=binary"};
    ASSERT_TRUE(until_watches(message_client));
    std::size_t sent = 0;
    for (std::uint8_t n = 0; n < 100; ++n) {
        send(frame(0xDC, 0xFF, 0x03, {n}) + frame(0xDC, 0x00, 0x03, {n}));    // to 0x00, which has no receiver
        sent += 2;
    }
    ASSERT_TRUE(until_in(sent));
    ASSERT_TRUE(gateway.gateway.until([&] { return seen(message_client).frames.size() == sent + 200; }))
        << seen(message_client).frames.size();
    const Seen all = seen(message_client);
    EXPECT_EQ(all.count.at("in"), gateway.gateway.count("a", "frames_in"));
    EXPECT_EQ(all.count.at("no_route"), gateway.gateway.count("a", "no_route"));
    EXPECT_EQ(all.count.at("out") + (all.count.contains("superseded") ? all.count.at("superseded") : 0), 100u);
    EXPECT_EQ(all.count.at("out"), gateway.gateway.count("b", "frames_out"));
}

TEST_F(Frames, changed_numbers_are_sent_before_the_next_frame) {
    MessageClient message_client{gateway, "/frames?format=binary"};
    ASSERT_TRUE(until_watches(message_client));
    MessageClient program{gateway, "/link?name=camera"};
    ASSERT_TRUE(until_open(program));
    ASSERT_TRUE(gateway.gateway.until([&] { return gateway.gateway.status().at("links").size() == 3; }));
    program.send(wind);
    ASSERT_TRUE(until_seen(message_client, 3)) << "in, and out by both links";
    ASSERT_GE(message_client.texts().size(), 2u);
    const json tables = json::parse(message_client.texts().back());
    EXPECT_EQ(tables.at("links"), (json{"a", "b", "control"}));
    EXPECT_EQ(tables.at("channels").at(2), "camera");
    std::string_view rest = message_client.messages().front();
    EXPECT_EQ(anogate::next_record(rest)->channel, 2);
}

TEST_F(Frames, are_sent_as_one_json_message_each) {
    MessageClient message_client{gateway, "/frames"};
    ASSERT_TRUE(gateway.gateway.until([&] { return gateway.gateway.gateway().forwarder().is_observed(); }));
    send(euler);
    ASSERT_TRUE(gateway.gateway.until([&] { return message_client.texts().size() == 2; }));
    const json in = json::parse(message_client.texts().at(0)), out = json::parse(message_client.texts().at(1));
    EXPECT_EQ(in.at("name"), "euler");
    EXPECT_EQ(in.at("fields").at("rol"), 1.23);
    EXPECT_EQ(in.at("link"), "a");
    EXPECT_EQ(in.at("direction"), "in");
    EXPECT_EQ(out.at("link"), "b");
    EXPECT_EQ(out.at("direction"), "out");
}

TEST_F(Frames, with_the_address_of_a_device_on_another_link_are_marked_and_can_be_omitted) {
    MessageClient all{gateway, "/frames?format=binary&direction=in"},
        believed{gateway, "/frames?format=binary&direction=in&elsewhere=no"};
    MessageClient lines{gateway, "/frames?direction=in"};
    ASSERT_TRUE(until_watches(all) && until_watches(believed));
    send(euler);
    ASSERT_TRUE(until_in(1));
    b.send(gateway.gateway.port("b"), euler);
    ASSERT_TRUE(gateway.gateway.until([&] { return gateway.gateway.count("b", "frames_in") == 1; }));
    send(wind);
    ASSERT_TRUE(until_seen(all, 3) && until_seen(believed, 2));
    std::vector<bool> marks;
    for (const std::string& message : all.messages()) {
        std::string_view rest = message;
        while (const auto record = anogate::next_record(rest)) marks.push_back(record->is_elsewhere);
    }
    EXPECT_EQ(marks, (std::vector<bool>{false, true, false}));
    EXPECT_EQ(seen(believed).frames, (std::vector<Bytes>{euler, wind}));
    ASSERT_TRUE(gateway.gateway.until([&] { return lines.texts().size() == 3; }));
    EXPECT_EQ(json::parse(lines.texts().at(1)).value("elsewhere", false), true);
    EXPECT_FALSE(json::parse(lines.texts().at(0)).contains("elsewhere"));
}

TEST_F(Frames, filters_select_frames_and_wrong_ones_are_reported) {
    MessageClient message_client{gateway, "/frames?format=binary&id=wind&direction=out&link=b&from=0xDD"};
    ASSERT_TRUE(until_watches(message_client));
    send(euler);
    send(wind);
    ASSERT_TRUE(until_in(2));
    ASSERT_TRUE(until_seen(message_client, 1));
    EXPECT_EQ(seen(message_client).frames.front(), wind);
    const auto refused = [&](const std::string& query) {
        const Answer answer = gateway.ask("GET", "/frames?" + query);
        EXPECT_EQ(answer.status, 400u) << answer.body;
        return json::parse(answer.body).at("error").get<std::string>();
    };
    EXPECT_EQ(refused("idd=3"),
              "unknown filter 'idd' (did you mean 'id'?); filters are from, to, id, link, direction, limit.ID, samples, "
              "elsewhere, batch, format and raw");
    EXPECT_EQ(refused("link=aa"), "there is no link 'aa'; use one of control, a, b");
    EXPECT_EQ(refused("format=binary"), "format=binary needs a WebSocket; lines are JSON");
    MessageClient wrong{gateway, "/frames?id=wnd"};
    ASSERT_TRUE(gateway.gateway.until([&] { return wrong.ended.has_value(); }));
    EXPECT_EQ(wrong.ended->answer.status, 400u);
    EXPECT_NE(wrong.ended->answer.body.find("did you mean 'wind'?"), std::string::npos) << wrong.ended->answer.body;
}

TEST_F(Frames, are_batched_for_the_requested_time_after_the_first_one) {
    MessageClient message_client{gateway, "/frames?format=binary&direction=in&batch=200ms"};
    ASSERT_TRUE(until_watches(message_client));
    std::size_t sent = 0;
    for (std::size_t messages = 0; messages < 4; messages = message_client.messages().size()) {
        for (int i = 0; i < 20; ++i) {    // too few to fill a batch
            send(euler);
            ASSERT_TRUE(until_in(++sent));
        }
        ASSERT_TRUE(gateway.gateway.until([&] { return message_client.messages().size() > messages; }));
    }
    ASSERT_TRUE(until_seen(message_client, sent));
    std::vector<std::chrono::nanoseconds> begun;
    for (const std::string& message : message_client.messages()) {
        std::string_view rest = message;
        begun.emplace_back(anogate::next_record(rest)->time_ns);
    }
    for (std::size_t i = 1; i < begun.size(); ++i) EXPECT_GT(begun[i] - begun[i - 1], 150ms);
}

// The loop is awake at that time, so a message needs no wake-up of its own.
TEST_F(Frames, are_sent_early_when_another_frame_arrives_shortly_before_their_time) {
    MessageClient message_client{gateway, "/frames?format=binary&direction=in&batch=200ms"};
    ASSERT_TRUE(until_watches(message_client));
    const auto is_early = [](const std::string& message) {
        std::vector<std::chrono::nanoseconds> times;
        for (std::string_view rest = message; const auto record = anogate::next_record(rest);)
            times.emplace_back(record->time_ns);
        return times.size() > 1 && times.back() - times.front() < 190ms;
    };
    bool some_are = false;
    for (std::size_t sent = 0, looked_at = 0; looked_at < 50 && !some_are; std::this_thread::sleep_for(5ms)) {
        send(euler);
        ASSERT_TRUE(until_in(++sent));
        for (; looked_at < message_client.messages().size(); ++looked_at)
            some_are = some_are || is_early(message_client.messages()[looked_at]);
    }
    EXPECT_TRUE(some_are) << "each waited for its time";
}

TEST_F(Frames, are_an_endless_stream_of_lines_without_an_upgrade) {
    anogate::http::Client client{gateway.loop.io, gateway.path};
    std::vector<std::string> lines;
    anogate::http::Request request;
    request.method = "GET";
    request.target = "/frames?direction=in";
    client.stream(
        request, [&](std::string_view line) { lines.emplace_back(line); }, [](anogate::http::Outcome) {});
    std::size_t sent = 0;
    ASSERT_TRUE(gateway.gateway.until([&] {
        if (lines.empty()) send(euler), ++sent;
        return !lines.empty();
    }));
    ASSERT_TRUE(until_in(sent));
    const std::size_t before = lines.size();
    send(wind);
    ASSERT_TRUE(gateway.gateway.until([&] { return !lines.empty() && json::parse(lines.back()).at("name") == "wind"; }))
        << before;
    EXPECT_EQ(json::parse(lines.front()).at("name"), "euler");
    client.cancel();
    for (int i = 0; i < 3; ++i) send(wind);    // no client watches any more
    EXPECT_TRUE(until_in(sent + 4));
}

TEST_F(Frames, that_were_dropped_are_sent_with_their_cause) {
    MessageClient message_client{gateway, "/frames?direction=dropped&format=binary"};
    ASSERT_TRUE(until_watches(message_client));
    send(frame(0xDC, 0x00, 0x03, {1}));
    ASSERT_TRUE(until_seen(message_client, 1));
    EXPECT_EQ(seen(message_client).count, (std::map<std::string, std::size_t>{{"no_route", 1}}));
}

// Reads nothing at first, and everything on request.
class Sleeper {
public:
    Sleeper(const std::string& path, const std::string& target) : fd_{connect_unix(path)} {
        const std::string request = "GET " + target + " HTTP/1.0\r\n\r\n";
        EXPECT_EQ(::send(fd_, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
        ::fcntl(fd_, F_SETFL, O_NONBLOCK);
    }
    ~Sleeper() { ::close(fd_); }
    Sleeper(const Sleeper&) = delete;
    Sleeper& operator=(const Sleeper&) = delete;
    /// The head of the answer has arrived: it receives frames from now on.
    bool has_begun() { return read().find("\r\n\r\n") != std::string::npos; }
    const std::string& read() {
        char buffer[65536];
        for (ssize_t n; (n = ::read(fd_, buffer, sizeof buffer)) > 0;) text_.append(buffer, static_cast<std::size_t>(n));
        return text_;
    }

private:
    int fd_;
    std::string text_;
};

TEST_F(Frames, a_client_that_does_not_read_delays_no_other_one_and_receives_a_report_of_lost_frames) {
    MessageClient awake{gateway, "/frames?format=binary&direction=in"};
    ASSERT_TRUE(until_watches(awake));
    Sleeper sleeper{gateway.path, "/frames?direction=in"};
    constexpr std::size_t count = 800;
    const Bytes big = frame(0xDC, 0xFF, 0xF1, Bytes(4000, 7));
    ASSERT_TRUE(gateway.gateway.until([&] { return sleeper.has_begun(); }));
    for (std::size_t i = 0; i < count; ++i) {
        send(big);
        ASSERT_TRUE(until_in(i + 1));
    }
    EXPECT_TRUE(until_seen(awake, count)) << "who reads misses nothing";
    EXPECT_EQ(awake.texts().size(), 1u);
    std::size_t shown = 0, lost = 0;
    std::size_t at = sleeper.read().find("\r\n\r\n") + 4;
    const auto sum = [&] {
        const std::string& text = sleeper.read();
        for (std::size_t end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
            const json line = json::parse(text.substr(at, end - at));
            if (line.contains("lost")) lost += line.at("lost").at("flexible1").get<std::size_t>();
            else ++shown;
        }
        return shown + lost == count;
    };
    EXPECT_TRUE(gateway.gateway.until(sum)) << shown << " shown, " << lost << " lost";
    EXPECT_GT(lost, 100u);
    EXPECT_GT(shown, 100u);
    send(wind);
    EXPECT_TRUE(gateway.gateway.until([&] {
        return sleeper.read().ends_with("}\n") && sleeper.read().find("wind") != std::string::npos;
    })) << "and it goes on";
}

TEST_F(Frames, a_client_that_reads_nothing_for_too_long_is_closed) {
    anogate::http::ServerLimits limits;
    limits.session.patience = 500ms;
    ControlledGateway impatient{settings_of_texts({a.link("x")}), limits};
    const auto is_watched = [&] { return impatient.gateway.gateway().forwarder().is_observed(); };
    Sleeper sleeper{impatient.path, "/frames?direction=in"};
    ASSERT_TRUE(impatient.gateway.until(is_watched));
    const Bytes big = frame(0xDC, 0xFF, 0xF1, Bytes(4000, 7));
    for (std::uint64_t sent = 0; is_watched() && sent < 5000;) {
        a.send(impatient.gateway.port("x"), big);
        ++sent;
        ASSERT_TRUE(impatient.gateway.until([&] { return impatient.gateway.count("x", "frames_in") >= sent; }));
        impatient.gateway.run_for(2ms);
    }
    EXPECT_FALSE(is_watched());
}

TEST_F(Frames, are_observed_only_while_a_client_watches) {
    const auto is_watched = [&] { return gateway.gateway.gateway().forwarder().is_observed(); };
    EXPECT_FALSE(is_watched());
    MessageClient one{gateway, "/frames?format=binary"}, two{gateway, "/frames?format=binary&id=wind"};
    ASSERT_TRUE(until_watches(one) && until_watches(two));
    EXPECT_TRUE(is_watched());
    one.leave();
    gateway.gateway.run_for(50ms);
    EXPECT_TRUE(is_watched());
    two.leave();
    EXPECT_TRUE(gateway.gateway.until([&] { return !is_watched(); }));
    EXPECT_EQ(gateway.ask("POST", "/send", R"({"to": 255, "name": "wind"})").status, 200u);
    EXPECT_FALSE(is_watched());
    MessageClient again{gateway, "/frames?format=binary"};
    ASSERT_TRUE(until_watches(again));
    send(wind);
    EXPECT_TRUE(until_seen(again, 2));
}

}    // namespace
}    // namespace frames_tests
