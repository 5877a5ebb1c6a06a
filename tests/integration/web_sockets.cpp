// WebSockets of the HTTP server over real sockets.
#include <integration/http_server.hpp>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace http_server {
namespace {

constexpr std::uint8_t continued = 0, op_text = 1, op_binary = 2, op_close = 8, op_ping = 9, op_pong = 10;

std::string upgrade(const std::string& more = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n") {
    return "GET /socket HTTP/1.1\r\nHost: x\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n" + more + "\r\n";
}

/// A client's frame according to RFC 6455.
std::string frame(std::uint8_t opcode, const std::string& data, bool last = true, bool masked = true) {
    const auto byte = [](std::size_t value) { return static_cast<char>(value & 0xFF); };
    std::string bytes{byte(opcode | (last ? 0x80u : 0u))};
    const std::size_t mask_bit = masked ? 0x80 : 0;
    if (data.size() < 126) bytes += byte(mask_bit | data.size());
    else bytes += {byte(mask_bit | 126), byte(data.size() >> 8), byte(data.size())};
    if (!masked) return bytes + data;
    const std::string mask = "\x12\x34\x56\x78";
    bytes += mask;
    for (std::size_t i = 0; i < data.size(); ++i) bytes += static_cast<char>(data[i] ^ mask[i % 4]);
    return bytes;
}
std::string close_frame(std::uint16_t code, const std::string& reason = {}) {
    return frame(op_close, std::string{static_cast<char>(code >> 8), static_cast<char>(code & 0xFF)} + reason);
}
/// A server's frame, which is not masked.
std::string from_server(std::uint8_t opcode, const std::string& data) { return frame(opcode, data, true, false); }
std::string closed_with(std::uint16_t code, const std::string& reason = {}) {
    return from_server(op_close, std::string{static_cast<char>(code >> 8), static_cast<char>(code & 0xFF)} + reason);
}

class WebSockets : public HttpServer {
protected:
    Client open(Transport way) {
        Client client = connect(way);
        client.send(upgrade());
        EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\n"); }));
        EXPECT_TRUE(client.heard().starts_with("HTTP/1.1 101 Switching Protocols")) << client.heard();
        EXPECT_TRUE(client.has_heard("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=")) << client.heard();
        EXPECT_TRUE(until([&] { return echo.socket != nullptr; }));
        client.heard().clear();
        return client;
    }
    bool receives_bytes(Client& client, const std::string& bytes) {
        const bool said = until([&] { return client.heard().size() >= bytes.size(); }) && client.heard().starts_with(bytes);
        if (said) client.heard().erase(0, bytes.size());
        return said;
    }
    /// The client receives the reason for the close, then the connection ends and its user is destroyed.
    bool ends_with(Client& client, const std::string& bytes) {
        return receives_bytes(client, bytes) && until([&] { return client.is_closed() && echo.gone; }) && client.heard().empty();
    }
};

INSTANTIATE_TEST_SUITE_P(Over, WebSockets, testing::Values(Transport::unix_socket, Transport::tcp),
                         [](const auto& way) { return way.param == Transport::tcp ? "tcp" : "unix"; });

TEST_P(WebSockets, carry_text_and_bytes_both_ways_in_order) {
    Client client = open(GetParam());
    std::string answers;
    for (const std::string& message : {std::string{"one"}, std::string(500, '2'), std::string(60'000, '3')}) {
        client.send(frame(op_text, message));
        answers += from_server(op_text, message);
    }
    client.send(frame(op_binary, std::string("\0\xFF\xAB", 3)) + frame(op_text, ""));
    answers += from_server(op_binary, std::string("\0\xFF\xAB", 3)) + from_server(op_text, "");
    EXPECT_TRUE(receives_bytes(client, answers));
    client.send(frame(op_text, "in ", false) + frame(op_ping, "between") + frame(continued, "pieces"));
    EXPECT_TRUE(receives_bytes(client, from_server(op_pong, "between") + from_server(op_text, "in pieces")));
    EXPECT_GT(echo.sent_all, 0);
    client.send(close_frame(1000));
    EXPECT_TRUE(ends_with(client, closed_with(1000)));
}

TEST_P(WebSockets, receive_messages_that_were_sent_together_with_the_request) {
    Client client = connect(GetParam());
    client.send(upgrade() + frame(op_text, "early") + frame(op_text, std::string(3000, 'e')));
    EXPECT_TRUE(
        until([&] { return client.has_heard(from_server(op_text, "early") + from_server(op_text, std::string(3000, 'e'))); }));
}

TEST_P(WebSockets, close_on_request_and_send_the_reason_to_the_client) {
    Client client = open(GetParam());
    echo.socket->close(1001, "the gateway is stopping");
    EXPECT_FALSE(echo.socket->send(std::make_shared<const std::string>("late"), WebSocket::Kind::text));
    EXPECT_TRUE(receives_bytes(client, closed_with(1001, "the gateway is stopping")));
    client.send(frame(op_text, "not heard any more") + close_frame(1001));
    EXPECT_TRUE(until([&] { return client.is_closed() && echo.gone; }));
}

TEST_P(WebSockets, close_when_memory_runs_out_without_affecting_others) {
    echo.has_memory = false;
    Client refused = connect(GetParam());
    refused.send(upgrade());
    EXPECT_TRUE(until([&] { return refused.is_closed() && echo.gone; }));
    echo = {};
    Client other = open(GetParam());
    echo.has_memory = false;
    other.send(frame(op_text, "x"));
    EXPECT_TRUE(until([&] { return other.is_closed() && echo.gone; }));
    echo = {};
    Client third = open(GetParam());
    echo.socket->attempt([] { throw std::bad_alloc{}; });
    EXPECT_FALSE(echo.socket->send(std::make_shared<const std::string>("late"), WebSocket::Kind::text));
    EXPECT_FALSE(echo.gone) << "whoever calls it may be running";
    EXPECT_TRUE(until([&] { return third.is_closed() && echo.gone; }));
    echo = {};
    Client fourth = open(GetParam());
    fourth.send(frame(op_text, "as before"));
    EXPECT_TRUE(receives_bytes(fourth, from_server(op_text, "as before")));
}

TEST_P(WebSockets, end_when_their_client_disconnects) {
    Client client = open(GetParam());
    client.leave();
    EXPECT_TRUE(until([&] { return echo.gone; }));
}

TEST_P(WebSockets, close_with_the_right_code_after_an_invalid_frame) {
    struct {
        std::string bytes;
        std::uint16_t code;
    } const bad[] = {
        {frame(op_text, "not masked", true, false), 1002},
        {frame(continued, "of nothing"), 1002},
        {frame(op_text, "one", false) + frame(op_text, "two"), 1002},
        {frame(3, "no such opcode"), 1002},
        {frame(op_ping, std::string(126, 'x')), 1002},
        {frame(op_text, "\xFF\xFE"), 1007},
        {frame(op_binary, std::string(65'535, 'x'), false) + frame(continued, "xx"), 1009},
    };
    for (const auto& [bytes, code] : bad) {
        echo = {};
        Client client = open(GetParam());
        client.send(bytes);
        EXPECT_TRUE(ends_with(client, closed_with(code))) << code << " " << client.heard().size();
    }
}

TEST_F(WebSockets, are_refused_with_a_reason_if_the_request_is_not_valid) {
    EXPECT_NE(answer("GET /socket HTTP/1.1\r\nConnection: close\r\n\r\n").find("426 Upgrade Required"), std::string::npos);
    EXPECT_TRUE(echo.gone);
    Client old = connect(), keyless = connect();
    old.send(upgrade("Sec-WebSocket-Version: 8\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"));
    keyless.send(upgrade("Sec-WebSocket-Version: 13\r\n"));
    EXPECT_TRUE(until([&] { return old.has_heard("only WebSocket version 13 is supported"); }));
    EXPECT_TRUE(until([&] { return keyless.has_heard("400 Bad Request"); }));
}

TEST_P(WebSockets, queue_messages_up_to_a_limit_if_the_client_does_not_read) {
    Client client = open(GetParam());
    const auto message = std::make_shared<const std::string>(64 * 1024, 'x');
    int taken = 0;
    const auto is_taken = [&] { return echo.socket->send(message, WebSocket::Kind::binary) && ++taken > 0; };
    ASSERT_TRUE(until([&] {
        while (is_taken()) continue;
        settle();
        return !is_taken();
    }));
    EXPECT_LE(echo.socket->waiting(), 1u << 20);
    EXPECT_EQ(message.use_count(), 1 + static_cast<long>(echo.socket->waiting() / message->size())) << "it is not copied";
    const std::size_t frame_size = message->size() + 10;
    EXPECT_TRUE(until([&] { return client.heard().size() >= static_cast<std::size_t>(taken) * frame_size; })) << taken;
    EXPECT_TRUE(until([&] { return echo.socket->waiting() == 0 && echo.sent_all > 0; }));
    EXPECT_TRUE(echo.socket->send(message, WebSocket::Kind::binary)) << "there is room again";
}

TEST_P(WebSockets, close_immediately_when_the_server_stops) {
    Client client = open(GetParam());
    server->stop();
    EXPECT_TRUE(echo.gone);
    settle();
    EXPECT_TRUE(client.is_closed());
}

class ImpatientWebSockets : public WebSockets {
protected:
    void SetUp() override {
        ServerLimits limits;
        limits.session.patience = 100ms;
        limits.session.web_socket.idle = 200ms;
        limits.session.web_socket.stuck = 100ms;
        begin(limits);
    }
};

INSTANTIATE_TEST_SUITE_P(Over, ImpatientWebSockets, testing::Values(Transport::unix_socket, Transport::tcp),
                         [](const auto& way) { return way.param == Transport::tcp ? "tcp" : "unix"; });

TEST_P(ImpatientWebSockets, stay_open_only_while_the_client_answers_pings) {
    Client client = open(GetParam());
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_TRUE(until([&] {
        if (client.has_heard(from_server(op_ping, ""))) {
            client.heard().clear();
            client.send(frame(op_pong, ""));
        }
        return std::chrono::steady_clock::now() - begin > 600ms;
    }));
    EXPECT_FALSE(echo.gone);
    EXPECT_TRUE(until([&] { return echo.gone; }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

TEST_P(ImpatientWebSockets, are_closed_when_the_client_reads_nothing) {
    Client client = open(GetParam());
    const auto message = std::make_shared<const std::string>(64 * 1024, 'x');
    // The client sends all the time; that it does not read is independent.
    EXPECT_TRUE(until([&] {
        if (!echo.gone) echo.socket->send(message, WebSocket::Kind::binary);
        client.send(frame(op_pong, ""));
        return echo.gone;
    }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

TEST_P(ImpatientWebSockets, close_without_a_close_frame_from_the_client) {
    Client client = open(GetParam());
    echo.socket->close(1000, "");
    EXPECT_TRUE(until([&] { return echo.gone; }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

// The deadline of the request expires in the turn of the loop in which the request is answered. Its timer is late then, and must
// not apply to the WebSocket.
TEST_F(WebSockets, stay_open_if_opened_just_after_the_request_deadline) {
    ServerLimits limits;
    limits.session.patience = 60ms;
    begin(limits);
    int opened = 0;
    for (int turns = 1; turns < 12; ++turns) {
        const auto connected = std::chrono::steady_clock::now();
        Client client = connect();
        settle();
        client.send(upgrade());
        io.restart();
        for (int i = 0; i < turns; ++i) io.poll_one();
        std::this_thread::sleep_until(connected + limits.session.patience + 5ms);    // the loop stalls
        settle();
        if (!client.has_heard("101")) continue;
        ++opened;
        const auto begin = std::chrono::steady_clock::now();
        EXPECT_TRUE(
            until([&] { return client.is_closed() || std::chrono::steady_clock::now() - begin > 2 * limits.session.patience; }));
        EXPECT_FALSE(client.is_closed()) << "after " << turns << " calls of the loop";
    }
    EXPECT_GT(opened, 3);
}

// Viewers occupy all places; each one keeps its place as long as it reads what it is sent.
TEST_F(JudgingHttpServer, accepts_a_control_client_however_many_viewers_are_connected) {
    const auto watch = [this](const std::string& headers) {
        Client client{UniqueFd{support::connect_tcp(port)}};
        client.send(
            "GET /watch HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
            headers + "\r\n");
        EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\n"); }));
        return client;
    };
    std::vector<Client> watchers;
    for (int i = 0; i < 40; ++i) watchers.push_back(watch(bearer("only-looks")));
    settle();
    constexpr std::ptrdiff_t viewers = 15;    // 20 places for streams, of which a quarter is reserved for control clients
    for (std::size_t i = 0; i < watchers.size(); ++i) EXPECT_EQ(watchers[i].has_heard("101"), i < viewers) << i;
    EXPECT_TRUE(watchers.back().has_heard("too many streams and WebSockets")) << watchers.back().heard();
    const auto gone = [&] {
        return std::count_if(watchers.begin(), watchers.begin() + viewers, [](Client& one) { return one.is_closed(); });
    };
    std::vector<Client> pilots;
    for (int i = 0; i < 5; ++i) pilots.push_back(watch(bearer("may-act")));
    settle();
    EXPECT_EQ(gone(), 0);
    pilots.push_back(watch(bearer("may-act")));
    EXPECT_TRUE(until([&] { return gone() == 1; })) << "those kept are taken: one who looks leaves";
    EXPECT_NE(ask("/large", bearer("may-act"), 3, 3).find("here 3"), std::string::npos);
    for (Client& pilot : pilots) EXPECT_TRUE(pilot.has_heard("101") && !pilot.is_closed());
}

// Each message takes as long to handle as a large one with thousands of names.
TEST_F(JudgingHttpServer, handles_a_command_between_messages_of_read_only_web_sockets) {
    std::vector<Client> crowd;
    for (int i = 0; i < 12; ++i) {
        crowd.emplace_back(UniqueFd{support::connect_tcp(port)});
        crowd.back().send(
            "GET /watch HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
            bearer("only-looks") + "\r\n");
        ASSERT_TRUE(until([&] { return crowd.back().has_heard("101 Switching"); })) << crowd.back().heard();
        crowd.back().heard().clear();
    }
    int heard = 0;
    echo.on_heard = [&heard] {
        ++heard;
        std::this_thread::sleep_for(10ms);
    };
    for (Client& one : crowd) one.send(frame(op_text, "a") + frame(op_text, "b"));
    Client pilot{UniqueFd{support::connect_tcp(port)}};
    ASSERT_TRUE(until([&] { return heard > 0; }));
    pilot.send("GET /short?n=landed HTTP/1.1\r\nHost: 127.0.0.1\r\n" + bearer("may-act") + "\r\n");
    const int before = heard;
    EXPECT_TRUE(until([&] { return pilot.has_heard("landed"); }));
    EXPECT_LE(heard - before, 3);
    EXPECT_TRUE(until([&] { return heard == 24; })) << heard;
}

// One user occupies all places for streams: they stay occupied as long as each client reads what it is sent.
TEST_F(WebSockets, keep_their_connection_quota_while_they_are_used) {
    std::vector<Client> watchers;
    for (int i = 0; i < 20; ++i) {
        watchers.push_back(connect());
        watchers.back().send(upgrade());
        settle();
        ASSERT_TRUE(until([&] { return watchers.back().has_heard("101"); }));
    }
    Client late = connect();
    late.send(upgrade());
    EXPECT_TRUE(until([&] { return late.has_heard("too many streams and WebSockets"); })) << late.heard();
    Client other = connect();
    other.send(get("/short?n=here"));
    EXPECT_TRUE(until([&] { return other.has_heard("here"); })) << "other requests have places of their own";
    source.ready = 1;
    source.ends = true;
    Client commander = connect();
    commander.send("POST /stream HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n");
    EXPECT_TRUE(until([&] { return commander.has_heard("HTTP/1.1 200"); })) << "the response of a job ends" << commander.heard();
    for (Client& watcher : watchers) EXPECT_FALSE(watcher.is_closed());
    watchers.pop_back();
    EXPECT_TRUE(until([&] {
        Client next = connect();
        next.send(upgrade());
        return until([&] { return next.has_heard("101") || next.has_heard("503"); }) && next.has_heard("101");
    }));
}

}    // namespace
}    // namespace http_server
