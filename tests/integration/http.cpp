// Sessions of the HTTP server over real sockets, with clients good and bad.
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
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

using namespace std::chrono_literals;
using namespace anogate::http;
using anogate::UniqueFd;
using support::connect_unix;
using support::patience;
using support::TempDir;

/// One that never waits.
class Client {
public:
    explicit Client(UniqueFd fd) : fd_{std::move(fd)} { ::fcntl(fd_.get(), F_SETFL, O_NONBLOCK); }

    /// As much as the server takes just now.
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
    /// As much of what is there as goes into a small buffer, of which the kernel holds no more than some for this client.
    std::size_t hear_a_little() {
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

/// Made while it is sent: as many parts as the test lets it.
class Source : public Producer {
public:
    struct State {
        int asked = 0;
        std::size_t part_size = 1;
        int ready = 0;    // parts that may be had
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

/// Says again what it hears; what it did is in the state.
class Echo : public WebSocketUser {
public:
    struct State {
        WebSocket* socket = nullptr;
        int sent_all = 0;
        bool gone = false;
        bool echoes = true;
    };
    explicit Echo(State& state) : state_{state} {}
    ~Echo() override { state_.gone = true; }
    void opened(WebSocket& socket) override { state_.socket = &socket; }
    void heard(std::string_view message, WebSocket::Kind kind) override {
        if (state_.echoes) state_.socket->send(std::make_shared<const std::string>(message), kind);
    }
    void sent_all() override { ++state_.sent_all; }

private:
    State& state_;
};

/// Keeps bodies in memory, as slowly as the test wants.
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

enum class Way { unix_socket, tcp };

class HttpServer : public testing::TestWithParam<Way> {
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
        server.emplace(io, limits, [this] { return has_memory; });
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
        routes.add("GET", "/stream", [this](const Request&) {
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
    Client connect(Way way = Way::unix_socket) {
        if (way == Way::unix_socket) return Client{UniqueFd{connect_unix(path)}};
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
    /// All that is said to `request`, up to the end of the connection.
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
    Source::State source;
    Echo::State echo;
    Keeping keeping;
    std::optional<Server> server;
};

std::string get(const std::string& target) { return "GET " + target + " HTTP/1.1\r\nHost: x\r\n\r\n"; }

bool is_told(const std::string& answer, const std::string& status, const std::string& words) {
    return answer.starts_with("HTTP/1.1 " + status) && answer.find("Content-Type: application/json\r\n") != answer.npos &&
           answer.find("Connection: close\r\n") != answer.npos && answer.find("{\"error\": \"" + words) != answer.npos;
}

INSTANTIATE_TEST_SUITE_P(Over, HttpServer, testing::Values(Way::unix_socket, Way::tcp),
                         [](const auto& way) { return way.param == Way::tcp ? "tcp" : "unix"; });

TEST_P(HttpServer, answers_pipelined_requests_in_their_order) {
    Client client = connect(GetParam());
    std::string all;
    for (int i = 0; i < 50; ++i) all += get("/short?n=<" + std::to_string(i) + ">");
    client.send(all);
    EXPECT_TRUE(until([&] { return client.has_heard("<49>"); })) << client.heard();
    std::size_t at = 0;
    for (int i = 0; i < 50; ++i) {
        at = client.heard().find("<" + std::to_string(i) + ">", at);
        ASSERT_NE(at, std::string::npos) << i;
    }
    EXPECT_FALSE(client.is_closed());
}

TEST_P(HttpServer, understands_who_speaks_byte_by_byte) {
    Client client = connect(GetParam());
    for (const char c : std::string{"POST /echo HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc"}) {
        client.send({&c, 1});
        settle();
    }
    EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\nabc"); }));
}

TEST_P(HttpServer, answers_who_has_closed_his_half) {
    Client client = connect(GetParam());
    client.send(get("/short?n=yes"));
    client.end_output();
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
    EXPECT_TRUE(client.has_heard("\r\n\r\nyes")) << client.heard();
}

TEST_P(HttpServer, tells_who_closed_his_half_within_a_request) {
    Client client = connect(GetParam());
    client.send("GET /sho");
    client.end_output();
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
    EXPECT_TRUE(is_told(client.heard(), "400 Bad Request", "the request ended before it was whole")) << client.heard();
}

TEST_F(HttpServer, tells_what_is_too_large_or_no_request_and_that_it_ends) {
    const std::string large = std::string(200'000, 'x');
    EXPECT_TRUE(is_told(answer("GET / HTTP/1.1\r\nX: " + large + "\r\n\r\n"), "431 Request Header Fields Too Large",
                        "the header of a request has at most 8192 bytes"));
    EXPECT_TRUE(is_told(answer("POST /echo HTTP/1.1\r\nContent-Length: 200000\r\n\r\n" + large), "413 Payload Too Large",
                        "the body of a request has at most 65536 bytes"));
    EXPECT_TRUE(is_told(answer("\x01\x02 HELLO\r\n\r\n" + large), "400 Bad Request", "this is not an HTTP request"));
    EXPECT_TRUE(is_told(answer("GET / HTTP/3.0\r\n\r\n"), "400 Bad Request", "this is not a request of HTTP/1.0 or HTTP/1.1"));
    const std::string two = answer(get("/short?n=one") + "GARBAGE\r\n\r\n");
    EXPECT_TRUE(two.starts_with("HTTP/1.1 200 OK")) << "what came before it is answered: " << two;
    EXPECT_NE(two.find("HTTP/1.1 400 Bad Request"), std::string::npos) << two;
}

TEST_F(HttpServer, tells_when_memory_is_short_and_when_to_come_again) {
    const std::string words = "there is too little memory for a request just now";
    const auto told = [&](const std::string& answer) {
        return is_told(answer, "503 Service Unavailable", words) && answer.find("Retry-After: 1\r\n") != answer.npos;
    };
    EXPECT_TRUE(told(answer(get("/none")))) << "it showed while the answer was made";
    Client in_time = connect();
    settle();
    has_memory = false;
    EXPECT_TRUE(told(answer(get("/short"))));
    in_time.send(get("/short"));
    EXPECT_TRUE(until([&] { return in_time.is_closed(); }));
    EXPECT_TRUE(told(in_time.heard())) << in_time.heard();
    has_memory = true;
    Client later = connect();
    later.send(get("/short"));
    EXPECT_TRUE(until([&] { return later.has_heard("200 OK"); }));
}

std::string post_of(std::size_t size) {
    return "POST /large HTTP/1.1\r\nConnection: close\r\nContent-Length: " + std::to_string(size) + "\r\n\r\n" +
           std::string(size, 'x');
}

TEST_F(HttpServer, keeps_a_large_body_in_parts_and_a_small_one_at_hand) {
    EXPECT_TRUE(answer(post_of(65'536)).ends_with("here 65536"));
    EXPECT_EQ(keeping.largest_part, 0u);
    EXPECT_TRUE(answer(post_of(65'537)).ends_with("stored 65537"));
    EXPECT_TRUE(answer(post_of(5'000'000)).ends_with("stored 5000000"));
    EXPECT_EQ(keeping.kept, std::string(5'000'000, 'x'));
    EXPECT_LT(keeping.largest_part, std::size_t{272} * 1024) << "what is held of it";
    const std::string chunk = "10000\r\n" + std::string(0x10000, 'y') + "\r\n";
    EXPECT_TRUE(
        answer("POST /large HTTP/1.1\r\nConnection: close\r\nTransfer-Encoding: chunked\r\n\r\n" + chunk + chunk + "0\r\n\r\n")
            .ends_with("stored 131072"));
    EXPECT_TRUE(is_told(answer(post_of((std::size_t{8} << 20) + 1)), "413 Payload Too Large",
                        "the body of a request has at most 8388608 bytes"));
}

TEST_F(HttpServer, says_why_a_large_body_can_not_be_kept) {
    keeping.fault = "there is no room";
    EXPECT_TRUE(is_told(answer(post_of(1'000'000)), "507 Insufficient Storage", "there is no room"));
}

TEST_F(HttpServer, keeps_two_large_bodies_at_a_time_and_none_of_who_has_gone) {
    keeping.waits = true;
    std::optional<Client> first = connect(), second = connect();
    const std::string part = post_of(1'000'000).substr(0, 300'000);
    for (std::size_t i = 0; i < 2; ++i) {
        std::size_t sent = 0;
        auto& client = i == 0 ? first : second;
        EXPECT_TRUE(until([&] {
            if (sent < part.size()) sent += client->send(std::string_view{part}.substr(sent));
            return keeping.done.size() == i + 1;
        }));
    }
    EXPECT_TRUE(is_told(answer(post_of(100'000)), "503 Service Unavailable", "other large bodies are on their way"));
    EXPECT_TRUE(answer(post_of(1000)).ends_with("here 1000")) << "a small one needs no place";
    EXPECT_NE(answer(post_of(100'000)).find("Retry-After: 1\r\n"), std::string::npos);
    keeping.waits = false;
    second.reset();
    for (const auto& done : std::exchange(keeping.done, {})) done("");
    EXPECT_TRUE(until([&] { return answer(post_of(100'000)).ends_with("stored 100000"); })) << "the place of who left is free";
}

TEST_F(HttpServer, a_large_body_in_chunks_has_a_place_when_it_is_large) {
    keeping.waits = true;
    std::vector<Client> clients;
    for (std::size_t i = 0; i < 2; ++i) {
        clients.push_back(connect());
        std::size_t sent = 0;
        const std::string part = post_of(1'000'000).substr(0, 300'000);
        EXPECT_TRUE(until([&] {
            if (sent < part.size()) sent += clients.back().send(std::string_view{part}.substr(sent));
            return keeping.done.size() == i + 1;
        }));
    }
    const std::string head = "POST /large HTTP/1.1\r\nConnection: close\r\nTransfer-Encoding: chunked\r\n\r\n";
    EXPECT_TRUE(answer(head + "3e8\r\n" + std::string(1000, 'y') + "\r\n0\r\n\r\n").ends_with("here 1000"));
    EXPECT_TRUE(is_told(answer(head + "20000\r\n" + std::string(0x20000, 'y') + "\r\n0\r\n\r\n"), "503 Service Unavailable",
                        "other large bodies are on their way"));
    for (const auto& done : std::exchange(keeping.done, {})) done("");
}

// Two who hold the places and send next to nothing.
TEST_F(HttpServer, who_sends_next_to_nothing_of_a_large_body_gives_way_to_another) {
    ServerLimits limits;
    limits.session.slow_body = 50ms;
    begin(limits);
    std::vector<Client> slow;
    for (int i = 0; i < 2; ++i) {
        slow.push_back(connect());
        slow.back().send(post_of(1'000'000).substr(0, 500));
    }
    const auto trickle = [&] {
        for (Client& client : slow) client.send("x");
    };
    Client other = connect();
    EXPECT_TRUE(until([&] {
        trickle();
        if (other.has_heard("503")) other = connect();
        if (other.heard().empty()) other.send(post_of(100'000));
        return other.has_heard("stored 100000") || other.has_heard("here");
    })) << other.heard();
    EXPECT_TRUE(until([&] { return slow[0].is_closed() || slow[1].is_closed(); }));
    Client& gone = slow[0].is_closed() ? slow[0] : slow[1];
    EXPECT_TRUE(is_told(gone.heard(), "408 Request Timeout", "too little of the body came for 50 ms")) << gone.heard();
    EXPECT_FALSE(slow[0].is_closed() && slow[1].is_closed()) << "one place was enough";
}

TEST_F(HttpServer, who_waits_to_be_told_to_send_a_body_is_told) {
    Client client = connect();
    client.send("POST /large HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 1000000\r\n\r\n");
    ASSERT_TRUE(until([&] { return client.has_heard("\r\n\r\n"); }));
    EXPECT_EQ(client.heard(), "HTTP/1.1 100 Continue\r\n\r\n");
    client.heard().clear();
    const std::string body(1'000'000, 'x');
    std::size_t sent = 0;
    EXPECT_TRUE(until([&] {
        sent += client.send(std::string_view{body}.substr(sent));
        return client.has_heard("stored 1000000");
    }));
    EXPECT_TRUE(client.heard().starts_with("HTTP/1.1 200 OK\r\n")) << client.heard();
    const std::string refused = answer("POST /echo HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 1000000\r\n\r\n");
    EXPECT_TRUE(refused.starts_with("HTTP/1.1 413 ")) << refused;
    client.heard().clear();
    client.send("POST /echo HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\nabc");
    EXPECT_TRUE(until([&] { return client.has_heard("abc"); }));
    EXPECT_TRUE(client.heard().starts_with("HTTP/1.1 200 OK\r\n")) << "the body came without it: " << client.heard();
}

// The tokens of a door to the network, and a route that takes much.
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

TEST_F(JudgingHttpServer, who_may_not_is_told_so_before_a_large_body_comes) {
    for (const std::string target : {"/large", "/echo"}) {
        EXPECT_TRUE(is_told(ask(target, ""), "401 Unauthorized", "this path needs a token")) << target;
        EXPECT_TRUE(is_told(ask(target, bearer("wrong")), "401 Unauthorized", "the token is not right")) << target;
        EXPECT_TRUE(is_told(ask(target, bearer("only-looks")), "403 Forbidden", "the token may not do this")) << target;
    }
    EXPECT_TRUE(is_told(ask("/echo", bearer("may-act")), "413 Payload Too Large", "the body of a request has at most 65536"));
    EXPECT_TRUE(
        is_told(ask("/large", bearer("may-act"), 9'000'000), "413 Payload Too Large", "the body of a request has at most"));
    EXPECT_NE(ask("/large", bearer("may-act"), 3, 3).find("here 3"), std::string::npos);
}

TEST_F(JudgingHttpServer, a_wrong_token_counts_once_a_request) {
    for (std::size_t i = 0; i + 1 < Attempts::max_failures; ++i)
        EXPECT_TRUE(ask("/large", bearer("wrong")).starts_with("HTTP/1.1 401 ")) << i;
    EXPECT_NE(ask("/large", bearer("may-act"), 3, 3).find("here 3"), std::string::npos);
    EXPECT_TRUE(ask("/large", bearer("wrong"), 3, 3).starts_with("HTTP/1.1 401 "));
    EXPECT_TRUE(ask("/large", bearer("may-act"), 3, 3).starts_with("HTTP/1.1 429 "));
}

class ImpatientHttpServer : public HttpServer {
protected:
    void SetUp() override {
        ServerLimits limits;
        limits.session.patience = 100ms;
        begin(limits);
    }
};

INSTANTIATE_TEST_SUITE_P(Over, ImpatientHttpServer, testing::Values(Way::unix_socket, Way::tcp),
                         [](const auto& way) { return way.param == Way::tcp ? "tcp" : "unix"; });

TEST_P(ImpatientHttpServer, parts_with_who_says_nothing_or_never_ends) {
    Client silent = connect(GetParam()), slow = connect(GetParam());
    slow.send("GET /sho");
    EXPECT_TRUE(until([&] { return slow.send("r"), silent.is_closed() && slow.is_closed(); }));
    EXPECT_EQ(silent.heard(), "");
    EXPECT_TRUE(is_told(slow.heard(), "408 Request Timeout", "the request was not whole within 100 ms")) << slow.heard();
}

// However slowly it comes, it comes.
TEST_F(ImpatientHttpServer, parts_with_who_stops_in_a_large_body_and_says_so) {
    Client slow = connect();
    slow.send(post_of(1'000'000).substr(0, 100'000));
    const auto begin = std::chrono::steady_clock::now();
    until([&] { return slow.send("x"), std::chrono::steady_clock::now() - begin > 500ms; });
    EXPECT_FALSE(slow.is_closed()) << slow.heard();
    EXPECT_TRUE(until([&] { return slow.is_closed(); }));
    EXPECT_TRUE(is_told(slow.heard(), "408 Request Timeout", "nothing more of the body came for 100 ms")) << slow.heard();
}

TEST_F(ImpatientHttpServer, says_that_the_disk_is_too_slow_where_it_is) {
    keeping.waits = true;
    Client client = connect();
    const std::string part = post_of(1'000'000).substr(0, 300'000);
    std::size_t sent = 0;
    EXPECT_TRUE(until([&] {
        if (sent < part.size()) sent += client.send(std::string_view{part}.substr(sent));
        return client.is_closed();
    }));
    EXPECT_TRUE(is_told(client.heard(), "503 Service Unavailable", "the disk is too slow")) << client.heard();
}

TEST_P(ImpatientHttpServer, parts_with_who_does_not_read_his_answer) {
    Client client = connect(GetParam());
    client.send(get("/big"));
    std::this_thread::sleep_for(10ms);
    const auto begin = std::chrono::steady_clock::now();
    until([&] { return std::chrono::steady_clock::now() - begin > 300ms; });
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
    EXPECT_LT(client.heard().size(), std::size_t{16 << 20});
}

class SlowlyReadHttpServer : public HttpServer {
protected:
    // Somewhat more than the server waits for whoever takes nothing.
    void read_slowly(Client& client) {
        client.hear_a_little();
        client.send(get("/big"));
        for (const auto begin = std::chrono::steady_clock::now(); std::chrono::steady_clock::now() - begin < 900ms;) {
            client.hear_a_little();
            io.restart();
            io.run_for(4ms);
        }
        ASSERT_LT(client.hear_a_little(), std::size_t{16 << 20}) << "he is to be still at it";
    }
};

INSTANTIATE_TEST_SUITE_P(Over, SlowlyReadHttpServer, testing::Values(Way::unix_socket, Way::tcp),
                         [](const auto& way) { return way.param == Way::tcp ? "tcp" : "unix"; });

TEST_P(SlowlyReadHttpServer, does_not_cut_its_client_off) {
    ServerLimits limits;
    limits.session.patience = 400ms;
    begin(limits);
    Client client = connect(GetParam());
    read_slowly(client);
    EXPECT_TRUE(until([&] { return client.heard().size() > (16 << 20) || client.is_closed(); }));
    EXPECT_GT(client.heard().size(), std::size_t{16 << 20});
}

TEST_F(SlowlyReadHttpServer, leaves_its_client_the_only_place_until_he_stops) {
    ServerLimits limits;
    limits.connections = 1;
    limits.session.stalled_after = 400ms;
    begin(limits);
    Client client = connect();
    read_slowly(client);
    const auto is_let_in = [&] {
        Client other = connect();
        other.send(get("/short?n=here"));
        EXPECT_TRUE(until([&] { return other.has_heard("here") || other.is_closed(); }));
        return other.has_heard("here");
    };
    EXPECT_FALSE(is_let_in());
    EXPECT_TRUE(until(is_let_in));
}

TEST_P(HttpServer, at_its_end_who_waits_for_his_turn_is_let_go_and_who_is_answered_is_told_all) {
    Client reads = connect(GetParam()), waits = connect(GetParam());
    reads.send(get("/big"));
    EXPECT_TRUE(until([&] { return reads.has_heard("200 OK"); }));
    settle();    // it waits to be read further
    waits.send(get("/short?n=late"));
    io.restart();
    EXPECT_EQ(io.poll_one(), 1u);    // it is heard, no more
    server->finish(std::chrono::hours{1});
    EXPECT_TRUE(until([&] { return waits.is_closed(); }));
    EXPECT_EQ(waits.heard(), "");
    EXPECT_FALSE(reads.is_closed());
    EXPECT_TRUE(until([&] { return reads.is_closed(); }));
    EXPECT_GT(reads.heard().size(), std::size_t{16 << 20});
}

TEST_F(HttpServer, who_waits_for_his_turn_is_told_when_his_place_is_anothers) {
    ServerLimits limits;
    limits.connections = 2;
    begin(limits);
    Client first = connect(), second = connect();
    settle();
    for (Client* client : {&first, &second}) client->send(get("/short?n=late"));
    io.restart();
    for (int i = 0; i < 2; ++i) EXPECT_EQ(io.poll_one(), 1u);    // they are heard, no more
    Client other = connect(Way::tcp);                            // of another user, who has a right to a place
    EXPECT_TRUE(until([&] { return first.is_closed(); }));
    EXPECT_TRUE(is_told(first.heard(), "503", "all places are taken")) << first.heard();
    EXPECT_TRUE(until([&] { return second.has_heard("late"); }));
}

TEST_P(HttpServer, many_have_one_text) {
    auto all = std::make_shared<const std::string>(std::string(8 << 20, 'z') + "end");
    server->routes().add("GET", "/shared", [&all](const Request&) {
        Response response = text("begin");
        response.shared = all;
        return response;
    });
    std::vector<Client> clients;
    for (int i = 0; i < 3; ++i) {
        clients.push_back(connect(GetParam()));
        clients.back().send(get("/shared") + get("/short?n=next"));
    }
    EXPECT_TRUE(until([&] { return all.use_count() == 4; })) << "who does not read holds no text of his own";
    for (Client& client : clients) {
        EXPECT_TRUE(until([&] { return client.has_heard("next"); }));
        const std::string& heard = client.heard();
        EXPECT_NE(heard.find("Content-Length: 8388616\r\n"), std::string::npos);
        const std::size_t body = heard.find("\r\n\r\n") + 4;
        EXPECT_EQ(heard.substr(body, 6), "beginz");
        EXPECT_EQ(heard.substr(body + 8'388'616 - 4, 12), "zendHTTP/1.1");
    }
    EXPECT_EQ(all.use_count(), 1);
    EXPECT_TRUE(answer("HEAD /shared HTTP/1.1\r\nConnection: close\r\n\r\n").ends_with("\r\n\r\n"));
}

TEST_P(HttpServer, streams_parts_as_they_come) {
    Client client = connect(GetParam());
    source.ready = 2;
    source.part_size = 3;
    client.send(get("/stream"));
    EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\n3\r\nxxx\r\n3\r\nxxx\r\n"); })) << client.heard();
    EXPECT_TRUE(client.has_heard("Transfer-Encoding: chunked"));
    client.heard().clear();
    source.ready = 1;
    source.wake();
    source.wake();
    EXPECT_TRUE(until([&] { return client.has_heard("3\r\nxxx\r\n"); }));
    client.send(get("/short?n=next"));
    settle();
    EXPECT_FALSE(client.has_heard("next")) << "until the stream has ended";
    source.ends = true;
    source.wake();
    EXPECT_TRUE(until([&] { return client.has_heard("0\r\n\r\nHTTP/1.1 200 OK") && client.has_heard("next"); }))
        << client.heard();
    EXPECT_TRUE(source.gone);
    source.wake();    // as late as it likes
    settle();
}

TEST_F(HttpServer, a_stream_of_http_1_0_ends_with_the_connection) {
    source.ready = 2;
    source.ends = true;
    const std::string all = answer("GET /stream HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
    EXPECT_TRUE(all.ends_with("\r\n\r\nxx")) << all;
    EXPECT_EQ(all.find("keep-alive"), std::string::npos) << all;
    const std::string head = answer("HEAD /stream HTTP/1.1\r\nConnection: close\r\n\r\n");
    EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
}

TEST_P(HttpServer, a_producer_is_asked_as_the_client_takes_its_parts) {
    Client client = connect(GetParam());
    source.part_size = 64 * 1024;
    source.ready = 1 << 20;
    client.send(get("/stream"));
    int before = -1;
    ASSERT_TRUE(until([&] { return std::exchange(before, source.asked) == source.asked && source.asked > 0; }));
    EXPECT_LT(source.asked, 400) << "what the sockets hold, and one";
    const int stopped = source.asked;
    EXPECT_TRUE(until([&] { return client.heard().size() > (40u << 20); }));
    EXPECT_GT(source.asked, stopped);
    client.leave();
    EXPECT_TRUE(until([&] { return source.gone; }));
}

TEST_P(HttpServer, a_producer_that_waits_goes_with_its_client) {
    Client client = connect(GetParam());
    client.send(get("/stream"));
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    client.leave();
    EXPECT_TRUE(until([&] { return source.gone; }));
}

TEST_P(ImpatientHttpServer, a_stream_that_is_not_read_is_cut_and_one_that_has_nothing_to_say_is_not) {
    Client client = connect(GetParam());
    client.send(get("/stream"));
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    const auto begin = std::chrono::steady_clock::now();
    until([&] { return std::chrono::steady_clock::now() - begin > 300ms; });
    EXPECT_FALSE(source.gone);
    source.part_size = 64 * 1024;
    source.ready = 1 << 20;
    source.wake();
    EXPECT_TRUE(until([&] { return source.gone; }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

TEST_P(HttpServer, who_is_streamed_to_cannot_fill_us_with_requests) {
    Client client = connect(GetParam());
    client.send(get("/stream"));
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    EXPECT_TRUE(until([&] { return client.send(get("/short")), client.is_closed(); }));
    EXPECT_TRUE(source.gone);
}

TEST_F(HttpServer, at_its_end_all_are_gone_at_once) {
    Client streamed = connect(), idle = connect(), half = connect();
    streamed.send(get("/stream"));
    half.send("GET /");
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    server->stop();
    EXPECT_TRUE(source.gone) << "not when the loop comes to it";
    settle();
    EXPECT_TRUE(streamed.is_closed() && idle.is_closed() && half.is_closed());
}

// ---- WebSocket

constexpr std::uint8_t continued = 0, said_text = 1, said_binary = 2, said_close = 8, said_ping = 9, said_pong = 10;

std::string upgrade(const std::string& more = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n") {
    return "GET /socket HTTP/1.1\r\nHost: x\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n" + more + "\r\n";
}

/// As RFC 6455 has it, from a client.
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
    return frame(said_close, std::string{static_cast<char>(code >> 8), static_cast<char>(code & 0xFF)} + reason);
}
/// Of the server: not masked.
std::string from_server(std::uint8_t opcode, const std::string& data) { return frame(opcode, data, true, false); }
std::string closed_with(std::uint16_t code, const std::string& reason = {}) {
    return from_server(said_close, std::string{static_cast<char>(code >> 8), static_cast<char>(code & 0xFF)} + reason);
}

class WebSockets : public HttpServer {
protected:
    Client open(Way way) {
        Client client = connect(way);
        client.send(upgrade());
        EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\n"); }));
        EXPECT_TRUE(client.heard().starts_with("HTTP/1.1 101 Switching Protocols")) << client.heard();
        EXPECT_TRUE(client.has_heard("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=")) << client.heard();
        EXPECT_TRUE(until([&] { return echo.socket != nullptr; }));
        client.heard().clear();
        return client;
    }
    bool says(Client& client, const std::string& bytes) {
        const bool said = until([&] { return client.heard().size() >= bytes.size(); }) && client.heard().starts_with(bytes);
        if (said) client.heard().erase(0, bytes.size());
        return said;
    }
    /// What closed it is told to the client, then it ends, and its user is gone.
    bool ends_with(Client& client, const std::string& bytes) {
        return says(client, bytes) && until([&] { return client.is_closed() && echo.gone; }) && client.heard().empty();
    }
};

INSTANTIATE_TEST_SUITE_P(Over, WebSockets, testing::Values(Way::unix_socket, Way::tcp),
                         [](const auto& way) { return way.param == Way::tcp ? "tcp" : "unix"; });

TEST_P(WebSockets, carry_text_and_bytes_both_ways_in_order) {
    Client client = open(GetParam());
    std::string answers;
    for (const std::string& message : {std::string{"one"}, std::string(500, '2'), std::string(60'000, '3')}) {
        client.send(frame(said_text, message));
        answers += from_server(said_text, message);
    }
    client.send(frame(said_binary, std::string("\0\xFF\xAB", 3)) + frame(said_text, ""));
    answers += from_server(said_binary, std::string("\0\xFF\xAB", 3)) + from_server(said_text, "");
    EXPECT_TRUE(says(client, answers));
    client.send(frame(said_text, "in ", false) + frame(said_ping, "between") + frame(continued, "pieces"));
    EXPECT_TRUE(says(client, from_server(said_pong, "between") + from_server(said_text, "in pieces")));
    EXPECT_GT(echo.sent_all, 0);
    client.send(close_frame(1000));
    EXPECT_TRUE(ends_with(client, closed_with(1000)));
}

TEST_P(WebSockets, hear_what_came_with_the_request) {
    Client client = connect(GetParam());
    client.send(upgrade() + frame(said_text, "early") + frame(said_text, std::string(3000, 'e')));
    EXPECT_TRUE(until(
        [&] { return client.has_heard(from_server(said_text, "early") + from_server(said_text, std::string(3000, 'e'))); }));
}

TEST_P(WebSockets, end_when_we_say_so_and_the_client_is_told_why) {
    Client client = open(GetParam());
    echo.socket->close(1001, "the gateway ends");
    EXPECT_FALSE(echo.socket->send(std::make_shared<const std::string>("late"), WebSocket::Kind::text));
    EXPECT_TRUE(says(client, closed_with(1001, "the gateway ends")));
    client.send(frame(said_text, "not heard any more") + close_frame(1001));
    EXPECT_TRUE(until([&] { return client.is_closed() && echo.gone; }));
}

TEST_P(WebSockets, end_with_their_client) {
    Client client = open(GetParam());
    client.leave();
    EXPECT_TRUE(until([&] { return echo.gone; }));
}

TEST_P(WebSockets, refuse_what_is_not_allowed_with_its_code) {
    struct {
        std::string bytes;
        std::uint16_t code;
    } const bad[] = {
        {frame(said_text, "not masked", true, false), 1002},
        {frame(continued, "of nothing"), 1002},
        {frame(said_text, "one", false) + frame(said_text, "two"), 1002},
        {frame(3, "no such opcode"), 1002},
        {frame(said_ping, std::string(126, 'x')), 1002},
        {frame(said_text, "\xFF\xFE"), 1007},
        {frame(said_binary, std::string(65'535, 'x'), false) + frame(continued, "xx"), 1009},
    };
    for (const auto& [bytes, code] : bad) {
        echo = {};
        Client client = open(GetParam());
        client.send(bytes);
        EXPECT_TRUE(ends_with(client, closed_with(code))) << code << " " << client.heard().size();
    }
}

TEST_F(WebSockets, are_refused_in_words_where_the_request_does_not_fit) {
    EXPECT_NE(answer("GET /socket HTTP/1.1\r\nConnection: close\r\n\r\n").find("426 Upgrade Required"), std::string::npos);
    EXPECT_TRUE(echo.gone);
    Client old = connect(), keyless = connect();
    old.send(upgrade("Sec-WebSocket-Version: 8\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"));
    keyless.send(upgrade("Sec-WebSocket-Version: 13\r\n"));
    EXPECT_TRUE(until([&] { return old.has_heard("a WebSocket of version 13 only"); }));
    EXPECT_TRUE(until([&] { return keyless.has_heard("400 Bad Request"); }));
}

TEST_P(WebSockets, queue_what_the_client_does_not_take_up_to_a_bound) {
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

TEST_P(WebSockets, are_gone_at_once_when_the_server_stops) {
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

INSTANTIATE_TEST_SUITE_P(Over, ImpatientWebSockets, testing::Values(Way::unix_socket, Way::tcp),
                         [](const auto& way) { return way.param == Way::tcp ? "tcp" : "unix"; });

TEST_P(ImpatientWebSockets, stay_while_the_client_answers_our_pings_and_no_longer) {
    Client client = open(GetParam());
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_TRUE(until([&] {
        if (client.has_heard(from_server(said_ping, ""))) {
            client.heard().clear();
            client.send(frame(said_pong, ""));
        }
        return std::chrono::steady_clock::now() - begin > 600ms;
    }));
    EXPECT_FALSE(echo.gone);
    EXPECT_TRUE(until([&] { return echo.gone; }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

TEST_P(ImpatientWebSockets, are_cut_when_the_client_takes_nothing) {
    Client client = open(GetParam());
    const auto message = std::make_shared<const std::string>(64 * 1024, 'x');
    // It says something all the time: that it does not read is another matter.
    EXPECT_TRUE(until([&] {
        if (!echo.gone) echo.socket->send(message, WebSocket::Kind::binary);
        client.send(frame(said_pong, ""));
        return echo.gone;
    }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

TEST_P(ImpatientWebSockets, whose_client_does_not_say_goodbye_are_closed_without) {
    Client client = open(GetParam());
    echo.socket->close(1000, "");
    EXPECT_TRUE(until([&] { return echo.gone; }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

// Who looks, as many as there are places: each holds his as long as he takes what he is sent.
TEST_F(JudgingHttpServer, who_controls_finds_a_place_however_many_look) {
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
    for (std::size_t i = 0; i < watchers.size(); ++i) {
        EXPECT_EQ(watchers[i].has_heard("101"), i < 28) << i;
        EXPECT_EQ(watchers[i].is_closed(), i >= 28) << i;
    }
    EXPECT_TRUE(is_told(watchers.back().heard(), "503 Service Unavailable", "all places are taken"));
    const Client pilot = watch(bearer("may-act"));
    EXPECT_NE(ask("/large", bearer("may-act"), 3, 3).find("here 3"), std::string::npos);
    EXPECT_FALSE(watchers.front().is_closed());
}

// As many as there are places, of one user: their places are taken as long as they take what they are sent.
TEST_F(WebSockets, keep_their_places_while_they_are_used) {
    std::vector<Client> watchers;
    for (int i = 0; i < 32; ++i) {
        watchers.push_back(connect());
        watchers.back().send(upgrade());
        settle();
        ASSERT_TRUE(until([&] { return watchers.back().has_heard("101"); }));
    }
    EXPECT_TRUE(is_told(answer(get("/short")), "503 Service Unavailable", "all places are taken"));
    watchers.pop_back();
    EXPECT_TRUE(until([&] {
        Client next = connect();
        next.send(get("/short?n=here"));
        return until([&] { return next.is_closed() || next.has_heard("here"); }) && next.has_heard("here");
    }));
}

}    // namespace
