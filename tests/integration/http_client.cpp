// The client of the control interface, against the server and against other sockets.
#include <http/client/client.hpp>
#include <http/server.hpp>
#include <support/loop.hpp>
#include <support/temp_dir.hpp>
#include <support/wait.hpp>

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace http_client_tests {
namespace {

using namespace std::chrono_literals;
using namespace anogate::http;
using support::TempDir;

/// Produces the given lines; ends when requested.
class Lines : public Producer {
public:
    struct State {
        std::string ready;
        bool ends = false;
        bool gone = false;
        std::function<void()> wake;
    };
    explicit Lines(State& state) : state_{state} {}
    ~Lines() override { state_.gone = true; }
    void start(std::function<void()> wake) override { state_.wake = std::move(wake); }
    Next next(std::string& into) override {
        into = std::exchange(state_.ready, {});
        if (!into.empty()) return Next::part;
        return state_.ends ? Next::end : Next::later;
    }

private:
    State& state_;
};

/// Stores the received messages, and whether the connection is open.
class MessageClient : public WebSocketUser {
public:
    struct State {
        WebSocket* socket = nullptr;
        std::vector<std::pair<std::string, WebSocket::Kind>> heard;
        bool gone = false;
    };
    explicit MessageClient(State& state) : state_{state} {}
    ~MessageClient() override {
        state_.gone = true;
        state_.socket = nullptr;
    }
    void opened(WebSocket& socket) override { state_.socket = &socket; }
    void heard(std::string_view message, WebSocket::Kind kind) override { state_.heard.emplace_back(message, kind); }

private:
    State& state_;
};

Request get(std::string target) {
    Request request;
    request.method = "GET";
    request.target = std::move(target);
    return request;
}

void send(WebSocket* socket, std::string words, WebSocket::Kind kind) {
    ASSERT_NE(socket, nullptr);
    EXPECT_TRUE(socket->send(std::make_shared<const std::string>(std::move(words)), kind));
}

class HttpClient : public testing::Test {
protected:
    HttpClient() : path{dir / "socket"} {}
    ~HttpClient() override {
        if (server) server->stop();
        loop.turn();
    }

    void serve(const ServerLimits& limits = {}) {
        server = std::make_unique<Server>(loop.io, limits);
        server->routes().add("POST", "/echo", [](const Request& request) {
            Response response;
            response.body = request.method + " " + std::string{request.header("Content-Type")} + " " + request.body;
            return response;
        });
        server->routes().add("GET", "/big", [](const Request&) {
            Response response;
            response.body.assign(300'000, 'x');
            return response;
        });
        server->routes().add("GET", "/lines", [this](const Request&) {
            Response response;
            response.producer = std::make_unique<Lines>(lines);
            return response;
        });
        server->routes().add("GET", "/ear", [this](const Request& request) {
            asked = request;
            Response response;
            response.web_socket = std::make_unique<MessageClient>(there);
            return response;
        });
        ASSERT_EQ(server->start(path).error, "");
    }

    Client::Done to_outcome() {
        return [this](Outcome came) { outcome = std::move(came); };
    }
    Outcome until_outcome() {
        EXPECT_TRUE(loop.until([&] { return outcome.has_value(); }));
        return outcome.value_or(Outcome{"nothing came", {}});
    }
    Outcome ask(Request request, const ClientLimits& limits = {}) {
        outcome.reset();
        Client client{loop.io, path, limits};
        client.ask(std::move(request), to_outcome());
        return until_outcome();
    }
    void open(Client& client, Request request) {
        client.open(std::move(request), std::make_unique<MessageClient>(here), to_outcome());
    }
    bool until_open() {
        return loop.until([&] { return here.socket != nullptr && there.socket != nullptr; });
    }

    TempDir dir;
    std::string path;
    support::Loop loop;
    Lines::State lines;
    MessageClient::State there, here;
    Request asked;
    std::optional<Outcome> outcome;
    std::unique_ptr<Server> server;
};

TEST_F(HttpClient, reads_a_whole_response) {
    serve();
    Request request = get("/echo");
    request.method = "POST";
    request.body = std::string(60'000, 'b');
    const Outcome echoed = ask(request);
    EXPECT_EQ(echoed.fault, "");
    EXPECT_EQ(echoed.answer.status, 200u);
    EXPECT_EQ(echoed.answer.header("content-TYPE"), "application/json");
    EXPECT_EQ(echoed.answer.body, "POST application/json " + request.body);
    EXPECT_EQ(ask(get("/big")).answer.body.size(), 300'000u);
    EXPECT_EQ(ask(get("/none")).answer.status, 404u);
}

TEST_F(HttpClient, returns_a_response_without_a_loop_of_the_caller) {
    serve();
    Outcome came;
    std::atomic<bool> done{false};
    std::thread other{[&] {
        came = anogate::http::ask(path, get("/big"));
        done = true;
    }};
    EXPECT_TRUE(loop.until([&] { return done.load(); }));
    other.join();
    EXPECT_EQ(came.answer.body.size(), 300'000u);
}

TEST_F(HttpClient, limits_the_length_of_a_response) {
    serve();
    ClientLimits limits;
    limits.body = 1000;
    EXPECT_EQ(ask(get("/big"), limits).fault, "the response of the gateway is longer than 1000 bytes");
}

TEST_F(HttpClient, receives_a_stream_line_by_line) {
    serve();
    std::vector<std::string> heard;
    Client client{loop.io, path};
    client.stream(
        get("/lines"), [&](std::string_view line) { heard.emplace_back(line); }, to_outcome());
    ASSERT_TRUE(loop.until([&] { return lines.wake != nullptr; }));
    const auto comes = [&](const std::string& text, std::size_t count) {
        lines.ready = text;
        lines.wake();
        return loop.until([&] { return heard.size() == count && lines.ready.empty(); });
    };
    EXPECT_TRUE(comes("one\ntwo\nthr", 2));
    EXPECT_TRUE(comes("ee\n", 3));
    EXPECT_EQ(heard, (std::vector<std::string>{"one", "two", "three"}));
    lines.ends = true;
    lines.wake();
    EXPECT_EQ(until_outcome().fault, "");
    EXPECT_EQ(outcome->answer.status, 200u);
}

TEST_F(HttpClient, limits_the_length_of_a_line_of_a_stream) {
    serve();
    ClientLimits limits;
    limits.line = 1000;
    lines.ready = std::string(2000, 'x');
    Client client{loop.io, path, limits};
    client.stream(
        get("/lines"), [](std::string_view) {}, to_outcome());
    EXPECT_EQ(until_outcome().fault, "a line of the gateway is longer than 1000 bytes");
    EXPECT_TRUE(loop.until([&] { return lines.gone; }));
}

TEST_F(HttpClient, returns_the_error_of_a_refused_stream) {
    serve();
    Client client{loop.io, path};
    client.stream(
        get("/line"), [](std::string_view) { FAIL(); }, to_outcome());
    EXPECT_EQ(until_outcome().answer.status, 404u);
    EXPECT_NE(outcome->answer.body.find("did you mean '/lines'?"), std::string::npos);
}

TEST_F(HttpClient, can_be_destroyed_in_the_middle_of_a_stream) {
    serve();
    auto client = std::make_unique<Client>(loop.io, path);
    lines.ready = "one\ntwo\n";
    int heard = 0;
    const auto leave = [&](std::string_view) {
        ++heard;
        client.reset();
    };
    client->stream(get("/lines"), leave, to_outcome());
    EXPECT_TRUE(loop.until([&] { return lines.gone; }));
    EXPECT_EQ(heard, 1);
    EXPECT_FALSE(outcome) << "who left is not told";
}

TEST_F(HttpClient, exchanges_messages_over_a_web_socket_in_both_directions) {
    serve();
    Client client{loop.io, path};
    Request request = get("/ear?id=1");
    request.headers.push_back({"Authorization", "Bearer x"});
    open(client, request);
    ASSERT_TRUE(until_open());
    EXPECT_EQ(asked.target, "/ear?id=1");
    EXPECT_EQ(asked.header("Authorization"), "Bearer x");
    const std::string binary("\xAB\0\xFF", 3);
    send(here.socket, binary, WebSocket::Kind::binary);
    send(here.socket, "text", WebSocket::Kind::text);
    send(there.socket, std::string(200'000, 'x'), WebSocket::Kind::binary);
    send(there.socket, "{}", WebSocket::Kind::text);
    EXPECT_TRUE(loop.until([&] { return there.heard.size() == 2 && here.heard.size() == 2; }));
    using Heard = std::vector<std::pair<std::string, WebSocket::Kind>>;
    EXPECT_EQ(there.heard, (Heard{{binary, WebSocket::Kind::binary}, {"text", WebSocket::Kind::text}}));
    EXPECT_EQ(here.heard, (Heard{{std::string(200'000, 'x'), WebSocket::Kind::binary}, {"{}", WebSocket::Kind::text}}));
    client.cancel();
    EXPECT_TRUE(loop.until([&] { return there.gone; }));
    EXPECT_TRUE(here.gone);
    EXPECT_FALSE(outcome);
}

TEST_F(HttpClient, reports_why_a_web_socket_was_closed) {
    serve();
    Client client{loop.io, path};
    open(client, get("/ear"));
    ASSERT_TRUE(until_open());
    there.socket->close(1008, "too slow");
    EXPECT_EQ(until_outcome().fault, "closed by the gateway: too slow");
    EXPECT_EQ(outcome->answer.status, 101u);
    EXPECT_TRUE(here.gone);

    here = there = {};
    outcome.reset();
    open(client, get("/ear"));
    ASSERT_TRUE(until_open());
    server->stop();
    EXPECT_EQ(until_outcome().fault, "the gateway closed the connection");
}

TEST_F(HttpClient, returns_the_error_of_a_refused_web_socket) {
    serve();
    Client client{loop.io, path};
    open(client, get("/eat"));
    EXPECT_EQ(until_outcome().fault, "");
    EXPECT_EQ(outcome->answer.status, 404u);
    EXPECT_NE(outcome->answer.body.find("did you mean '/ear'?"), std::string::npos);
    EXPECT_TRUE(here.gone);
    EXPECT_EQ(here.socket, nullptr);
}

TEST_F(HttpClient, retries_while_the_quota_is_used_up) {
    ServerLimits limits;
    limits.local.streams = 1;
    serve(limits);
    Client first{loop.io, path};
    first.stream(
        get("/lines"), [](std::string_view) {}, [](Outcome) {});
    ASSERT_TRUE(loop.until([&] { return lines.wake != nullptr; }));
    EXPECT_EQ(ask(get("/lines"), {.patience = 500ms}).answer.status, 503u);
    outcome.reset();
    Client second{loop.io, path};
    second.ask(get("/lines"), to_outcome());
    loop.until([&] { return outcome.has_value(); }, 100ms);
    first.cancel();
    lines.ends = true;
    EXPECT_EQ(until_outcome().answer.status, 200u);
}

TEST_F(HttpClient, reports_that_no_gateway_is_running) {
    EXPECT_EQ(ask(get("/")).fault, "no gateway is running at " + path + ": socket not found (another one: --control PATH)");
    path = dir.write("file", "");
    EXPECT_EQ(ask(get("/")).fault, path + " is not a socket");
    path = "/" + std::string(200, 'x');
    EXPECT_EQ(ask(get("/")).fault, path + ": the path of a socket has at most 107 bytes");
}

/// A socket of another program, which sends `words` to each client and closes the connection, or sends nothing.
class Stranger {
public:
    explicit Stranger(const std::string& path, int type = SOCK_STREAM) : fd_{::socket(AF_UNIX, type | SOCK_CLOEXEC, 0)} {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        if (type == SOCK_STREAM) {
            EXPECT_EQ(::listen(fd_, 1), 0);
        }
    }
    ~Stranger() { ::close(fd_); }
    void send(const std::string& words) const {
        const int client = ::accept(fd_, nullptr, nullptr);
        EXPECT_EQ(::send(client, words.data(), words.size(), MSG_NOSIGNAL), static_cast<ssize_t>(words.size()));
        ::shutdown(client, SHUT_WR);
        char asked[1000];
        while (::read(client, asked, sizeof asked) > 0) {}
        ::close(client);
    }

private:
    int fd_;
};

TEST_F(HttpClient, reports_a_server_that_is_not_a_gateway) {
    const auto said = [&](const std::string& words) {
        path = dir / "stranger";
        const Stranger stranger{path};
        std::thread speaks{[&] { stranger.send(words); }};
        const Outcome came = ask(get("/"));
        speaks.join();
        ::unlink(path.c_str());
        return came.fault;
    };
    const std::string what = "the program at " + dir / "stranger";
    EXPECT_EQ(said(""), what + " closed the connection without a response");
    EXPECT_EQ(said("SSH-2.0-OpenSSH_9.2p1\r\n\r\n").find(what + " is not a gateway: "), 0u);
    EXPECT_EQ(said("HTTP/1.1 200 OK\r\nServer: other\r\nContent-Length: 0\r\n\r\n"), what + " is not a gateway");
    EXPECT_EQ(said("HTTP/1.1 200 OK\r\nServer: anogate\r\nContent-Length: 9\r\n\r\n1"),
              "the gateway stopped before its response was complete");
    path = dir / "datagrams";
    const Stranger datagrams{path, SOCK_DGRAM};
    EXPECT_EQ(ask(get("/")).fault, "the program at " + path + " is not a gateway");
}

TEST_F(HttpClient, does_not_wait_for_ever) {
    const Stranger silent{path};    // it queues two connections and accepts none; the system keeps further ones out
    std::vector<std::unique_ptr<Client>> clients;
    int late = 0;
    for (int i = 0; i < 4; ++i) {
        clients.push_back(std::make_unique<Client>(loop.io, path, ClientLimits{.patience = 200ms}));
        clients.back()->ask(get("/"), [&](const Outcome& came) {
            EXPECT_EQ(came.fault, "the gateway at " + path + " did not answer within 200 ms");
            ++late;
        });
    }
    EXPECT_TRUE(loop.until([&] { return late == 4; }));
    Client client{loop.io, path, {.patience = 200ms}};
    open(client, get("/ear"));
    EXPECT_NE(until_outcome().fault, "");
}

}    // namespace
}    // namespace http_client_tests
