// Sessions for whoever comes: who gets a place, whose turn it is, who has to go.
#pragma once
#include <http/admission.hpp>
#include <http/asio.hpp>
#include <http/farewell.hpp>
#include <http/listener.hpp>
#include <http/local_socket.hpp>
#include <http/routes.hpp>
#include <http/session.hpp>
#include <http/tls.hpp>
#include <http/turns.hpp>

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate::http {

struct ServerLimits {
    std::size_t connections = 32;
    std::size_t farewells = 32;           // connections that end and are told why
    std::size_t farewells_in_need = 4;    // while memory is short: each takes some
    ano::Duration farewell = std::chrono::seconds{1};
    SessionLimits session;
};

/// Its clients take turns with the loop: one request of one of them, whoever asks longest, then what came in meanwhile.
class Server : private SessionOwner {
public:
    /// Whether the system has memory for one request and its answer.
    using HasMemory = std::function<bool()>;

    explicit Server(asio::io_context& io, const ServerLimits& limits = {}, HasMemory has_memory = {});
    ~Server() override { stop(); }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// What is answered. Changed before the first client comes.
    Routes& routes() noexcept { return routes_; }

    /// Where bodies go that are larger than usual; else they are held in memory.
    void keep_large_bodies(MakeKeeper make) { make_keeper_ = std::move(make); }

    struct Outcome {
        std::string error;      // empty: it listens
        bool in_use = false;    // another program has the path: it may be free later
        std::string notice;     // it listens, but not for all whom one might expect
    };
    /// Listens at the path of a Unix socket (LocalSocket). After an error it may be tried again.
    Outcome start(const std::string& path);

    struct Network {
        std::string address;           // "127.0.0.1", "::"
        std::uint16_t port = 0;        // 0: the kernel chooses
        bool needs_token = true;       // else every client may everything
        std::shared_ptr<Tls> tls{};    // nullptr: not encrypted
    };
    /// Listens there; the port, or why not. After an error it may be tried again.
    Expected<std::uint16_t> start(const Network& network);
    /// Whose tokens and which names count at network doors.
    Admission& admission() noexcept { return admission_; }
    /// A client by a connection of any sort.
    void admit(std::unique_ptr<Stream> stream);
    /// As stop(), but what is being answered is answered to its end, or for `patience`; nobody is let in, and nothing more is heard.
    void finish(ano::Duration patience);
    /// Closes everything at once and removes the socket; producers and users of WebSockets are gone then. The loop may still hold what
    /// will not run: it must not run after us.
    void stop();

private:
    std::vector<Visitor> visitors();
    bool make_place(std::uint32_t user, const Door& door);
    void send_away(std::size_t place);
    void shut();
    void look_whether_finished(ano::TimePoint until);
    void give_turn();

    void wait_for_turn(std::shared_ptr<Session> session) override;
    tl::expected<Access, Response> judge(const Request& request) override;
    std::optional<Response> crowded_out(Access access) override;
    Response answer(Request& request) override;
    tl::expected<BodyRoom, Response> room_for_body(const Request& head) override;
    tl::expected<std::shared_ptr<void>, Response> place_for_body() override;
    void refuse(std::unique_ptr<Stream> stream, const Response& words) override;
    std::unique_ptr<BodyKeeper> keeper() override { return make_keeper_ ? make_keeper_() : nullptr; }
    bool has_memory() override;
    bool still_has_memory() override;

    asio::io_context& io_;
    ServerLimits limits_;
    asio::steady_timer finish_check_{io_};
    HasMemory has_memory_;
    ano::TimePoint memory_seen_at_{};    // and none was used for an answer since
    MakeKeeper make_keeper_;
    std::shared_ptr<int> large_bodies_ = std::make_shared<int>();    // one more owner for each
    Routes routes_;
    Admission admission_;
    LocalSocket local_;
    std::unique_ptr<Listener> local_listener_, network_listener_;
    std::vector<std::weak_ptr<Session>> sessions_;
    Turns<std::shared_ptr<Session>> turns_;    // each with a whole request
    std::deque<std::weak_ptr<Farewell>> farewells_;
};

}    // namespace anogate::http
