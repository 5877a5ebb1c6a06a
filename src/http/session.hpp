// One connection with all its requests.
#pragma once
#include <http/open_web_socket.hpp>
#include <http/places.hpp>
#include <http/request_reader.hpp>
#include <http/response.hpp>
#include <http/stream.hpp>
#include <sys/expected.hpp>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace anogate::http {

class Session;

struct SessionLimits {
    RequestLimits request;
    WebSocketLimits web_socket;
    /// Maximum time until a complete request or more of a large body is received, and until the client accepts more of a
    /// response.
    ano::Duration patience = std::chrono::seconds{30};
    /// A client that sends less than 1 KiB of a large body in this time gives way to another one.
    ano::Duration slow_body = std::chrono::seconds{3};
    /// Bytes of a large body that are collected before they are passed to its keeper.
    std::size_t part_of_body = std::size_t{256} * 1024;
    /// A client that has accepted nothing of a response for this time counts as idle; a response that takes longer is marked as
    /// Client::lasts.
    ano::Duration stalled_after = std::chrono::seconds{1};
};

/// The decisions about the body of a request, made when its head is known.
struct BodyRoom {
    std::uint64_t max_bytes = 0;
    std::optional<Access> judged{};    // the access of the request, if it was judged for this
    std::shared_ptr<void> place{};     // of a large body: place_for_body()
};

/// The server of a session. Sessions do not call it after close().
class SessionOwner {
public:
    virtual ~SessionOwner() = default;
    /// Calls run_turn() when it is the session's turn. Sessions that may control are first, then the parties in rotation.
    virtual void wait_for_turn(std::shared_ptr<Session> session, const ClientId& client_id, Access access) = 0;
    /// The access of a request, or the response that refuses it.
    virtual tl::expected<Access, Response> judge(Request& request) = 0;
    /// For a request with `access`, which the session's visitor() already has: the last response of the session if there are too
    /// many such requests; std::nullopt: continue.
    virtual std::optional<Response> refusal_if_full(const ClientId& client_id, Access access) = 0;
    /// Whether a request with this head (nullptr: the next one of the party) is likely to be one that may control. The decision
    /// is made by judge().
    virtual bool may_control(const ClientId& client_id, const Request* head) = 0;
    /// Whether one more handshake of the party may wait for its turn.
    virtual bool may_begin_handshake(const ClientId& client_id) = 0;
    /// To be called before a response that lasts: a stream, or one that waits for a job (`streams` is false). Returns the
    /// response that refuses it; std::nullopt: continue.
    virtual std::optional<Response> refusal_if_no_place(const ClientId& client_id, Access access, bool streams) = 0;
    /// The response to `request`; may move from it.
    virtual Response answer(Request& request) = 0;
    /// The limit for the body of `head`, or the response that refuses the body before it is received.
    virtual tl::expected<BodyRoom, Response> room_for_body(Request& head) = 0;
    /// A place for a large body, to be held as long as the body; or the response to send if all places are in use.
    virtual tl::expected<std::shared_ptr<void>, Response> place_for_body() = 0;
    /// For a large body; nullptr: it is held in memory.
    virtual std::unique_ptr<BodyKeeper> keeper() = 0;
    /// Ends the connection with this answer.
    virtual void refuse(std::unique_ptr<Stream> stream, const Response& words) = 0;
    /// Whether there is memory for one request and its answer.
    virtual bool has_memory() = 0;
    /// The same, for a session that has just called has_memory(): does not query the system again within a millisecond.
    virtual bool still_has_memory() = 0;
};

/// Reads requests one after the other; each is answered before the next is read. Lives as long as its connection, or until close().
/// A client that sends nothing, accepts nothing or sends no HTTP gets an error or is disconnected.
class Session : public std::enable_shared_from_this<Session> {
public:
    Session(asio::io_context& io, SessionOwner& owner, std::unique_ptr<Stream> stream, const SessionLimits& limits);

    /// To be called first; for an encrypted connection, after its client has sent something.
    void start();
    /// To be called when it is its turn: answers the request, starts the handshake, or passes a message to the user of its
    /// WebSocket.
    void run_turn();
    const ClientId& client_id() const noexcept { return client_id_; }
    bool awaits_handshake() const noexcept { return stream_ && awaits_handshake_; }
    /// Closes at once; destroys the producer or the user of the WebSocket.
    void close();
    /// To be called when the server stops: completes the current response, or the next part of a stream; otherwise closes at
    /// once.
    void finish();
    /// True while the client waits for a response that is not made yet (Response::patient).
    bool awaits_answer() const noexcept { return answer_awaited_; }
    /// As finish(), for a client that has no access any more; a WebSocket is closed at once.
    void dismiss();
    /// The token of the current or the last request; empty: there was none.
    const std::string& token() const noexcept { return token_; }
    Access may() const noexcept { return may_.value_or(Access::open); }
    bool is_of_network() const noexcept { return is_of_network_; }
    /// Ends the session because another client gets its place. Sends `words` unless it is idle or in the middle of a response.
    void leave(const Response& words);
    ClientConnection connection(ano::TimePoint now) const;
    /// True if its client has sent a request, or a part of it, that was not read yet.
    bool has_more() const { return stream_ && asking_ != Asking::whole && stream_->has_more(); }
    /// The time since which the client has sent too little of a large body; std::nullopt: it sends fast enough, or no large body.
    std::optional<ano::TimePoint> body_waits_since() const;
    /// Refuses its large body, so that another client can use the place.
    void abort_body();

private:
    void await_request();
    void read();
    void came(error_code ec, std::size_t size);
    template <class Function>
    void guarded(Function function);
    void refuse_for_memory() noexcept;
    void input_ended();
    void receive();
    bool has_room(Request& head);
    void send_continue();
    bool stores_body();
    bool has_place_for(std::size_t held);
    void on_body(std::size_t size);
    void store_body(const std::string& fault);
    void on_request();
    void answer(Request& request);
    void await_answer(std::shared_ptr<void> needed);
    std::function<void()> turns_of_web_socket();
    void send(Response response, bool head_only);
    void write();
    void wrote_some();
    void wrote();
    void next_part();
    void next_part_soon();
    bool sends_part(bool is_last);
    void wake();
    void refuse(const Response& words);
    void expect_progress();
    void expect_nothing();
    void end_deadline();
    void await_deadline();
    void lost_patience();

    asio::io_context& io_;
    SessionOwner& owner_;
    const SessionLimits& limits_;
    std::unique_ptr<Stream> stream_;    // nullptr: closed, refused or a WebSocket
    asio::steady_timer deadline_;
    std::optional<ano::TimePoint> patient_until_;    // std::nullopt: no deadline
    bool deadline_runs_ = false;                     // deadline_ is set, to patient_until_ or earlier
    std::uint32_t user_;
    ClientId client_id_;
    bool is_of_network_;
    std::string token_{};
    std::optional<Access> may_;             // the access of the current or the last request
    bool by_address_ = false;               // `may_` is assumed, since the party controlled before
    std::optional<Request> request_;        // complete, and waits for its turn
    std::optional<Response> unanswered_;    // the response if it is refused
    std::optional<Field> also_;             // an additional header of its response

    Asking asking_ = Asking::unheard;
    bool awaits_turn_ = false;    // has a complete request
    bool awaits_handshake_ = false;
    bool streams_ = false;    // the response is a stream or a WebSocket
    bool reading_ = false;
    bool input_ended_ = false;
    ano::TimePoint since_;         // when it connected or last made progress
    ano::TimePoint whole_at_{};    // when the current or the last request was complete
    std::array<char, 4 * 1024> room_;
    std::string input_;    // received but not parsed yet
    std::optional<RequestReader> reader_;

    Sending sending_;
    std::string head_, body_;    // being written, followed by shared_
    std::shared_ptr<const std::string> shared_ = nothing_;
    static const std::shared_ptr<const std::string> nothing_;
    std::size_t written_ = 0;
    std::unique_ptr<Producer> producer_;
    bool part_awaited_ = false;      // the producer has no part for now
    bool has_length_ = false;        // the producer's response has a length
    std::uint64_t to_come_ = 0;      // bytes of it still to be made
    bool answer_awaited_ = false;    // with Response::patient
    std::shared_ptr<void> needed_;
    BodyRoom room_for_body_;             // of the current request
    std::optional<Response> refusal_;    // of the request's body
    bool go_on_awaited_ = false;         // 100 Continue
    bool is_kept_ = false;               // the keeper is storing a part of the body
    std::size_t came_since_ = 0;         // bytes of the body received since body_since_
    ano::TimePoint body_since_{};
    std::unique_ptr<BodyKeeper> keeper_;
    bool woken_ = false;
    bool finishes_ = false;
    bool last_part_ = false;    // of a stream, in finish()
    std::weak_ptr<OpenWebSocket> web_socket_;
};

}    // namespace anogate::http
