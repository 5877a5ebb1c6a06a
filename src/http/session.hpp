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
    /// Maximum time until a complete request or more of a large body has come, and until the client has taken more of an answer.
    ano::Duration patience = std::chrono::seconds{30};
    /// A client that sends less than 1 KiB of a large body in this time gives way to another one.
    ano::Duration slow_body = std::chrono::seconds{3};
    /// Bytes of a large body that are collected before they are given to its keeper.
    std::size_t part_of_body = std::size_t{256} * 1024;
    /// A client that has taken nothing of an answer for this time counts as idle; an answer that takes longer lasts.
    ano::Duration stalled_after = std::chrono::seconds{1};
};

/// What is decided about the body of a request when its head is known.
struct BodyRoom {
    std::uint64_t max_bytes = 0;
    std::optional<Access> judged{};    // what the request may do, if it was judged for this
    std::shared_ptr<void> place{};     // of a large body: place_for_body()
};

/// The server of a session. Sessions do not call it after close().
class SessionOwner {
public:
    virtual ~SessionOwner() = default;
    /// Calls take_turn() when it is the session's turn. Those that may control come first, then each party in turn.
    virtual void wait_for_turn(std::shared_ptr<Session> session, const Party& party, Access access) = 0;
    /// What a request may do, or the answer that refuses it.
    virtual tl::expected<Access, Response> judge(Request& request) = 0;
    /// For a request with `access`, which the session's visitor() already has: the last answer of the session if there are too many such
    /// requests; std::nullopt: go on.
    virtual std::optional<Response> crowded_out(const Party& party, Access access) = 0;
    /// Whether a request with this head, or nullptr, the next one of the party, is likely to be one that may control. What decides is judge().
    virtual bool may_control(const Party& party, const Request* head) = 0;
    /// Whether one more handshake of the party may wait for its turn.
    virtual bool may_shake_hands(const Party& party) = 0;
    /// Before an answer that stays: a stream, or one that waits for a job (`streams` is false). The answer that refuses it; std::nullopt: go on.
    virtual std::optional<Response> no_room_to_stay(const Party& party, Access access, bool streams) = 0;
    /// Takes what it needs out of `request`.
    virtual Response answer(Request& request) = 0;
    /// What is allowed for the body of `head`, or the answer that refuses it before it comes.
    virtual tl::expected<BodyRoom, Response> room_for_body(Request& head) = 0;
    /// A place for a large body, to be held as long as that; or the answer if all of the few places are taken.
    virtual tl::expected<std::shared_ptr<void>, Response> place_for_body() = 0;
    /// For a large body; nullptr: it is held in memory.
    virtual std::unique_ptr<BodyKeeper> keeper() = 0;
    /// Ends the connection with this answer.
    virtual void refuse(std::unique_ptr<Stream> stream, const Response& words) = 0;
    /// Whether there is memory for one request and its answer.
    virtual bool has_memory() = 0;
    /// The same, for a session that called has_memory() just before: need not ask the system again.
    virtual bool still_has_memory() = 0;
};

/// Reads requests one after the other; each is answered before the next is read. Lives as long as its connection, or until close().
/// A client that sends nothing, takes nothing or sends no HTTP gets an error or is disconnected.
class Session : public std::enable_shared_from_this<Session> {
public:
    Session(asio::io_context& io, SessionOwner& owner, std::unique_ptr<Stream> stream, const SessionLimits& limits);

    /// The client of an encrypted connection has sent something.
    void start();
    /// Its turn: the request is answered, the handshake begins, or a message of its WebSocket is heard.
    void take_turn();
    const Party& party() const noexcept { return party_; }
    bool awaits_handshake() const noexcept { return stream_ && awaits_handshake_; }
    /// Closes at once; destroys the producer or the user of the WebSocket.
    void close();
    /// The server is stopping: completes the current answer, or the next part of a stream; everything else ends at once.
    void finish();
    /// A client waits for an answer that is not made yet (Response::patient).
    bool awaits_answer() const noexcept { return answer_awaited_; }
    /// As finish(), for a client that may not ask any more; a WebSocket ends at once.
    void dismiss();
    /// The token of the current or the last request; empty: there was none.
    const std::string& token() const noexcept { return token_; }
    Access may() const noexcept { return may_.value_or(Access::open); }
    bool is_of_network() const noexcept { return is_of_network_; }
    /// Gives its place to another client. Sends `words` unless it is in the middle of an answer.
    void leave(const Response& words);
    Visitor visitor(ano::TimePoint now) const;
    /// Since when the client has sent too little of a large body; std::nullopt: it has not.
    std::optional<ano::TimePoint> body_waits_since() const;
    /// Gives the place of its large body to another client's.
    void give_up_body();

private:
    void await_request();
    void read();
    void came(error_code ec, std::size_t size);
    template <class Function>
    void guarded(Function function);
    void refuse_for_memory() noexcept;
    void input_ended();
    void hear();
    bool has_room(Request& head);
    void say_go_on();
    bool puts_body();
    bool has_place_for(std::size_t held);
    void body_came(std::size_t size);
    void put_body(const std::string& fault);
    void came_whole();
    void answer(Request& request);
    void await_answer(std::shared_ptr<void> needed);
    std::function<void()> turns_of_web_socket();
    void send(Response response, bool head_only);
    void write();
    void wrote_some();
    void wrote();
    void next_part();
    void next_part_soon();
    bool takes_part(bool is_last);
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
    Party party_;
    bool is_of_network_;
    std::string token_{};
    std::optional<Access> may_;             // what the current or the last request may do
    bool by_address_ = false;               // it is supposed, since others of its client controlled
    std::optional<Request> request_;        // complete, and waits for its turn
    std::optional<Response> unanswered_;    // why it is refused instead
    std::optional<Field> also_;             // a header of its answer

    Asking asking_ = Asking::unheard;
    bool awaits_turn_ = false;    // has a complete request
    bool awaits_handshake_ = false;
    bool streams_ = false;    // the answer is a stream or a WebSocket
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
    bool part_awaited_ = false;      // the producer has none for now
    bool has_length_ = false;        // the producer's answer has a length
    std::uint64_t to_come_ = 0;      // bytes of it still to be made
    bool answer_awaited_ = false;    // with Response::patient
    std::shared_ptr<void> needed_;
    BodyRoom room_for_body_;             // of the current request
    std::optional<Response> refusal_;    // of the request's body
    bool go_on_awaited_ = false;         // 100 Continue
    bool is_kept_ = false;               // the keeper is storing a part of the body
    std::size_t came_since_ = 0;         // bytes of the body since body_since_
    ano::TimePoint body_since_{};
    std::unique_ptr<BodyKeeper> keeper_;
    bool woken_ = false;
    bool finishes_ = false;
    bool last_part_ = false;    // of a stream, in finish()
    std::weak_ptr<OpenWebSocket> web_socket_;
};

}    // namespace anogate::http
