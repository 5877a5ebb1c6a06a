// The HTTP server: accepts connections, gives them places and turns, and closes them.
#pragma once
#include <http/asio.hpp>
#include <http/listeners/admission.hpp>
#include <http/listeners/final_response.hpp>
#include <http/listeners/listener.hpp>
#include <http/listeners/local_socket.hpp>
#include <http/listeners/new_connections.hpp>
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

/// The limits of one kind of listener.
struct ListenerLimits {
    std::size_t connections = 0;
    std::size_t streams = 0;    // of the connections: streams and WebSockets, which stay
    std::size_t in_need = 0;    // replaces `connections` while few descriptors are left; there are no streams then
    ano::Duration hearing{};    // a new connection keeps its place for this time, even if nothing is received on it
};

struct ServerLimits {
    // Up to 20 requests may wait for devices (DeviceService::waiting_places): beside them and the streams some places stay free.
    ListenerLimits local{44, 20, 3, std::chrono::milliseconds{100}};
    ListenerLimits network{44, 20, 1, std::chrono::milliseconds{100}};
    std::size_t final_responses = 32;           // closing connections that are still sent their last response
    std::size_t final_responses_in_need = 4;    // the same while memory is short
    ano::Duration final_response = std::chrono::seconds{1};
    SessionLimits session;
};

/// Between two requests the loop does its other work. Users of the Unix socket and clients of the network have separate places. A
/// client without a place waits in the kernel's queue, but only while requests that may control take all places and no response
/// of them lasts.
class Server : private SessionOwner {
public:
    /// Whether the system has memory for one request and its answer.
    using HasMemory = std::function<bool()>;

    explicit Server(asio::io_context& io, const ServerLimits& limits = {}, HasMemory has_memory = {});
    ~Server() override { stop(); }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// The paths that are answered. Must not be changed after start().
    Routes& routes() noexcept { return routes_; }

    /// Where bodies above SessionLimits::request.body are stored; without it they are held in memory.
    void keep_large_bodies(MakeKeeper make) { make_keeper_ = std::move(make); }

    struct Outcome {
        std::string error;      // empty: it listens
        bool in_use = false;    // another program has the path: it may be free later
        std::string notice;     // it listens, but some users that might be expected can't connect
    };
    /// Listens at the path of a Unix socket (LocalSocket). After an error it may be tried again.
    Outcome start(const std::string& path);

    struct Network {
        std::string address;           // "127.0.0.1", "::"
        std::uint16_t port = 0;        // 0: the kernel chooses
        bool needs_token = true;       // false: every client may do everything
        std::shared_ptr<Tls> tls{};    // nullptr: not encrypted
    };
    /// Listens there. Returns the port, or the error; after that it may be called again.
    Expected<std::uint16_t> start(const Network& network);
    /// Stops listening there; its clients receive only the responses that are being made.
    void stop_network();
    /// Used for clients that connect from now on.
    void set_tls(std::shared_ptr<Tls> tls) { network_settings_.tls = std::move(tls); }
    /// Replaces the rules. Calls Session::dismiss() for clients whose token allows less now.
    void set_rules(AdmissionRules rules);
    /// The rules for network listeners: tokens and names.
    Admission& admission() noexcept { return admission_; }
    const Admission& admission() const noexcept { return admission_; }
    /// Connections of the network that were silent or waited for a place, and were closed for others.
    const EvictionCounter& evicted() const noexcept { return evicted_; }
    /// Adds a client with any sort of connection.
    void admit(std::unique_ptr<Stream> stream);
    /// As stop(), but responses in progress are completed within `patience`, and those that are not made yet may be sent until
    /// no_more_answers(). Accepts no connections and reads no requests meanwhile.
    void finish(ano::Duration patience);
    /// To be called after finish(): closes the connections whose response is not made yet.
    void no_more_answers();
    /// Closes everything at once and removes the socket; destroys producers and users of WebSockets. The loop may still hold handlers of
    /// the server and must not run after its destruction.
    void stop();

private:
    /// The sessions of one sort of listener.
    struct Quota {
        ListenerLimits limits;
        std::vector<std::weak_ptr<Session>> sessions{};

        std::vector<ClientConnection> connections();
    };
    Quota& quota_of(const ClientId& client_id) noexcept { return client_id.user == unknown_user ? network_ : local_; }
    bool is_full(const Quota& quota, std::size_t connections) const;
    std::optional<std::size_t> connection_to_close(const Quota& quota, std::vector<ClientConnection> connections) const;
    bool has_place(Quota& quota);
    std::ptrdiff_t handshakes(const ClientId* of);
    bool make_place(Quota& quota);
    void evict_excess(Quota& quota, std::size_t at_least);
    void send_away(Quota& quota, std::size_t place);
    void remember(const ClientId& client_id, Access access);
    template <class Call>
    void for_each_session(Call call);
    void dismiss_those(const std::function<bool(const Session& session)>& wanted);
    bool may_accept();
    void add_new(Socket socket);
    void shut_network();
    void shut();
    void look_whether_finished(ano::TimePoint until);
    void close_those(bool awaiting_answer);
    void schedule_turn();
    void schedule_turn_soon();
    void run_turn(Session& session);

    void wait_for_turn(std::shared_ptr<Session> session, const ClientId& client_id, Access access) override;
    tl::expected<Access, Response> judge(Request& request) override;
    std::optional<Response> refusal_if_full(const ClientId& client_id, Access access) override;
    bool may_control(const ClientId& client_id, const Request* head) override;
    bool may_begin_handshake(const ClientId& client_id) override;
    std::optional<Response> refusal_if_no_place(const ClientId& client_id, Access access, bool streams) override;
    Response answer(Request& request) override;
    tl::expected<BodyRoom, Response> room_for_body(Request& head) override;
    tl::expected<std::shared_ptr<void>, Response> place_for_body() override;
    void refuse(std::unique_ptr<Stream> stream, const Response& words) override;
    std::unique_ptr<BodyKeeper> keeper() override { return make_keeper_ ? make_keeper_() : nullptr; }
    bool has_memory() override;
    bool still_has_memory() override;

    asio::io_context& io_;
    ServerLimits limits_;
    asio::steady_timer finish_check_{io_};
    HasMemory has_memory_;
    ano::TimePoint memory_seen_at_{};    // when memory was last found free; {}: an answer was made since
    MakeKeeper make_keeper_;
    std::shared_ptr<int> large_bodies_ = std::make_shared<int>();    // its use count - 1 is the number of large bodies
    Routes routes_;
    Admission admission_;
    LocalSocket local_socket_;
    Network network_settings_;
    EvictionCounter evicted_;
    std::unique_ptr<NewConnections> new_connections_;    // of the network
    std::unique_ptr<Listener> local_listener_, network_listener_;
    Quota local_{limits_.local}, network_{limits_.network};
    std::deque<ClientId> controllers_;                   // clients of the network that have controlled, the most recent last
    Turns<std::shared_ptr<Session>, ClientId> turns_;    // sessions with a complete request
    asio::steady_timer rest_{io_};
    ano::TimePoint rests_until_{};    // sessions that may not control have no turn before
    std::deque<std::weak_ptr<FinalResponse>> final_responses_;
};

}    // namespace anogate::http
