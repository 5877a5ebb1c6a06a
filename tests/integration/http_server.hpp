// An HTTP server over real sockets, with correct and faulty clients.
#pragma once
#include <http/server.hpp>
#include <support/http.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/wait.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace http_server {

using namespace std::chrono_literals;
using namespace anogate::http;
using anogate::UniqueFd;
using support::connect_unix;
using support::patience;
using support::TempDir;

/// A client that never waits.
class Client {
public:
    explicit Client(UniqueFd fd) : fd_{std::move(fd)} { ::fcntl(fd_.get(), F_SETFL, O_NONBLOCK); }

    /// Sends as much as the server accepts now.
    std::size_t send(std::string_view text) {
        std::size_t sent = 0;
        while (sent < text.size()) {
            const ssize_t n = ::send(fd_.get(), text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
            if (n <= 0) break;
            sent += static_cast<std::size_t>(n);
        }
        return sent;
    }
    void end_output() { ::shutdown(fd_.get(), SHUT_WR); }
    void leave() { fd_ = UniqueFd{}; }
    std::string& heard() {
        char buffer[65536];
        ssize_t n;
        while ((n = ::read(fd_.get(), buffer, sizeof buffer)) > 0) heard_.append(buffer, static_cast<std::size_t>(n));
        closed_ = closed_ || n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR);
        return heard_;
    }
    /// Reads once into a small buffer; the kernel's receive buffer for this client is small too.
    std::size_t receive_some() {
        constexpr int room = 64 * 1024;
        ::setsockopt(fd_.get(), SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
        char buffer[32 * 1024];
        const ssize_t n = ::read(fd_.get(), buffer, sizeof buffer);
        if (n > 0) heard_.append(buffer, static_cast<std::size_t>(n));
        closed_ = closed_ || n == 0;
        return heard_.size();
    }
    bool is_closed() { return heard(), closed_; }
    bool has_heard(std::string_view words) { return heard().find(words) != std::string::npos; }

private:
    UniqueFd fd_;
    std::string heard_;
    bool closed_ = false;
};

/// Produced while it is sent: as many parts as the test allows.
class Source : public Producer {
public:
    struct State {
        int asked = 0;
        std::size_t part_size = 1;
        int ready = 0;    // parts that are available
        bool ends = false;
        bool gone = false;
        std::function<void()> wake;
    };
    explicit Source(State& state) : state_{state} {}
    ~Source() override { state_.gone = true; }
    void start(std::function<void()> wake) override { state_.wake = std::move(wake); }
    Next next(std::string& into) override {
        ++state_.asked;
        if (state_.ready == 0) return state_.ends ? Next::end : Next::later;
        --state_.ready;
        into.assign(state_.part_size, 'x');
        return Next::part;
    }

private:
    State& state_;
};

/// Sends back each message that it receives; its actions are in the state.
class Echo : public WebSocketUser {
public:
    struct State {
        WebSocket* socket = nullptr;
        int sent_all = 0;
        bool gone = false;
        bool echoes = true;
        bool has_memory = true;    // false: it throws std::bad_alloc
        std::function<void()> on_heard;
    };
    explicit Echo(State& state) : state_{state} {}
    ~Echo() override { state_.gone = true; }
    void opened(WebSocket& socket) override {
        state_.socket = &socket;
        if (!state_.has_memory) throw std::bad_alloc{};
    }
    void heard(std::string_view message, WebSocket::Kind kind) override {
        if (!state_.has_memory) throw std::bad_alloc{};
        if (state_.on_heard) state_.on_heard();
        if (state_.echoes) state_.socket->send(std::make_shared<const std::string>(message), kind);
    }
    void sent_all() override { ++state_.sent_all; }

private:
    State& state_;
};

/// Stores bodies in memory, as slowly as the test requires.
struct Keeping {
    std::string kept;
    std::string fault;
    std::size_t largest_part = 0;
    bool waits = false;    // until one of `done` is called
    std::vector<std::function<void(std::string)>> done;
};

class Stored : public StoredBody {
public:
    explicit Stored(std::string bytes) : bytes_{std::move(bytes)} {}
    std::uint64_t size() const override { return bytes_.size(); }
    bool read(std::uint64_t at, std::span<std::uint8_t> into) const override {
        bytes_.copy(reinterpret_cast<char*>(into.data()), into.size(), at);
        return true;
    }

private:
    std::string bytes_;
};

class Keeper : public BodyKeeper {
public:
    Keeper(anogate::asio::io_context& io, Keeping& state) : io_{io}, state_{state} { state_.kept.clear(); }
    void put(std::string part, std::function<void(std::string)> done) override {
        state_.largest_part = std::max(state_.largest_part, part.size());
        state_.kept += part;
        if (state_.waits) state_.done.push_back(std::move(done));
        else anogate::asio::post(io_, [done = std::move(done), fault = state_.fault] { done(fault); });
    }
    std::shared_ptr<const StoredBody> whole() const override { return std::make_shared<Stored>(state_.kept); }

private:
    anogate::asio::io_context& io_;
    Keeping& state_;
};

enum class Transport { unix_socket, tcp };

class HttpServer : public testing::TestWithParam<Transport> {
protected:
    void SetUp() override { begin({}); }
    void TearDown() override {
        server->stop();
        io.restart();
        io.poll();
        server.reset();
    }
    void begin(const ServerLimits& limits) {
        if (server) TearDown();
        server.emplace(io, limits, [this] { return ++memory_looks, has_memory; });
        Routes& routes = server->routes();
        routes.add("GET", "/short",
                   [](const Request& request) { return text(std::string{request.query_value("n").value_or("")}); });
        routes.add("POST", "/echo", [](const Request& request) { return text(request.body); });
        routes.add({"POST",
                    "/large",
                    anogate::http::Access::control,
                    {},
                    [](const Request& request) {
                        return text(request.stored ? "stored " + std::to_string(request.stored->size())
                                                   : "here " + std::to_string(request.body.size()));
                    },
                    std::uint64_t{8} << 20});
        server->keep_large_bodies([this] { return std::make_unique<Keeper>(io, keeping); });
        routes.add("GET", "/big", [](const Request&) { return text(std::string(16 << 20, ' ')); });
        routes.add("GET", "/none", [](const Request&) -> Response { throw std::bad_alloc{}; });
        for (const char* method : {"GET", "POST"})
            routes.add(method, "/stream", [this](const Request&) {
                Response response;
                response.producer = std::make_unique<Source>(source);
                return response;
            });
        routes.add("GET", "/socket", [this](const Request&) {
            Response response;
            response.web_socket = std::make_unique<Echo>(echo);
            return response;
        });
        ASSERT_EQ(server->start(path).error, "");
    }
    static Response text(std::string body) {
        Response response;
        response.body = std::move(body);
        return response;
    }
    Client connect(Transport way = Transport::unix_socket) {
        if (way == Transport::unix_socket) return Client{UniqueFd{connect_unix(path)}};
        const UniqueFd listening{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        auto* const generic = reinterpret_cast<sockaddr*>(&address);
        EXPECT_EQ(::bind(listening.get(), generic, size), 0);
        EXPECT_EQ(::listen(listening.get(), 1), 0);
        EXPECT_EQ(::getsockname(listening.get(), generic, &size), 0);
        UniqueFd ours{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
        EXPECT_EQ(::connect(ours.get(), generic, size), 0);
        const int theirs = ::accept4(listening.get(), nullptr, nullptr, SOCK_CLOEXEC);
        server->admit(stream_of(Socket{io, anogate::asio::generic::stream_protocol{AF_INET, IPPROTO_TCP}, theirs}));
        return Client{std::move(ours)};
    }
    bool until(const std::function<bool()>& holds) {
        return support::wait_until(holds, patience, [this] {
            io.restart();
            io.run_for(1ms);
        });
    }
    void settle() {
        io.restart();
        io.poll();
    }
    /// Everything sent in answer to `request`, up to the end of the connection.
    std::string answer(const std::string& request) {
        Client client = connect();
        for (std::size_t sent = 0; sent < request.size() && !client.is_closed(); settle())
            sent += client.send(std::string_view{request}.substr(sent));
        EXPECT_TRUE(until([&] { return client.is_closed(); })) << client.heard();
        return client.heard();
    }

    TempDir dir;
    std::string path = dir / "http.sock";
    anogate::asio::io_context io{1};
    bool has_memory = true;
    int memory_looks = 0;
    Source::State source;
    Echo::State echo;
    Keeping keeping;
    std::optional<Server> server;
};

inline std::string get(const std::string& target) { return "GET " + target + " HTTP/1.1\r\nHost: x\r\n\r\n"; }

inline bool has_error(const std::string& answer, const std::string& status, const std::string& words) {
    return answer.starts_with("HTTP/1.1 " + status) && answer.find("Content-Type: application/json\r\n") != answer.npos &&
           answer.find("Connection: close\r\n") != answer.npos && answer.find("{\"error\": \"" + words) != answer.npos;
}

inline std::string post_of(std::size_t size) {
    return "POST /large HTTP/1.1\r\nConnection: close\r\nContent-Length: " + std::to_string(size) + "\r\n\r\n" +
           std::string(size, 'x');
}

// Tokens of a network listener, and a route with large bodies.
class JudgingHttpServer : public HttpServer {
protected:
    void SetUp() override {
        begin({});
        AdmissionRules rules;
        rules.tokens = {{Access::view, "only-looks"}, {Access::control, "may-act"}};
        server->admission().set(std::move(rules));
        server->routes().add({"GET", "/watch", Access::view, {}, [this](const Request&) {
                                  Response response;
                                  response.web_socket = std::make_unique<Echo>(echo);
                                  return response;
                              }});
        const auto listens = server->start(Server::Network{.address = "127.0.0.1", .needs_token = true});
        ASSERT_TRUE(listens) << listens.error();
        port = *listens;
    }
    std::string ask(const std::string& target, const std::string& headers, std::size_t size = 1'000'000, std::size_t sent = 0) {
        Client client{UniqueFd{support::connect_tcp(port)}};
        client.send("POST " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/octet-stream\r\n" + headers +
                    "Content-Length: " + std::to_string(size) + "\r\n\r\n" + std::string(sent, 'x'));
        EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\n"); }));
        return client.heard();
    }
    static std::string bearer(const std::string& token) { return "Authorization: Bearer " + token + "\r\n"; }

    std::uint16_t port = 0;
};

class ImpatientHttpServer : public HttpServer {
protected:
    void SetUp() override {
        ServerLimits limits;
        limits.session.patience = 100ms;
        begin(limits);
    }
};

}    // namespace http_server
