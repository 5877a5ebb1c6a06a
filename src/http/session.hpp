// One connection, from its first request to its last.
#pragma once
#include <http/open_web_socket.hpp>
#include <http/places.hpp>
#include <http/request_reader.hpp>
#include <http/response.hpp>
#include <http/stream.hpp>
#include <link/expected.hpp>

#include <array>
#include <memory>
#include <optional>
#include <string>

namespace anogate::http {

class Session;

struct SessionLimits {
    RequestLimits request;
    WebSocketLimits web_socket;
    /// Until a whole request, or something more of a large body, has come, until something of an answer was taken.
    ano::Duration patience = std::chrono::seconds{30};
    /// Who sends less than 1 KiB of a large body in so long gives way to another one.
    ano::Duration slow_body = std::chrono::seconds{3};
    /// Of a large body so much is held until its keeper has it.
    std::size_t part_of_body = std::size_t{256} * 1024;
    /// Who has not taken anything of an answer for so long counts as idle.
    ano::Duration stalled_after = std::chrono::seconds{1};
};

/// For the body of a request of which the rest is known.
struct BodyRoom {
    std::uint64_t most = 0;            // bytes that it may have
    std::optional<Access> judged{};    // what the request may, where that was asked for it
    std::shared_ptr<void> place{};     // of a large one that tells its size
};

/// Whoever let sessions in. It outlives what they do: none calls it after close().
class SessionOwner {
public:
    virtual ~SessionOwner() = default;
    /// Calls take_turn() in its time.
    virtual void wait_for_turn(std::shared_ptr<Session> session) = 0;
    /// What a request may, or the answer that refuses it.
    virtual tl::expected<Access, Response> judge(const Request& request) = 0;
    /// Of a request that may so much, of a session that says so already: the last words of that session, where too many of the sort
    /// are answered already.
    virtual std::optional<Response> crowded_out(Access access) = 0;
    /// `request` is as its answer left it, which takes what it needs.
    virtual Response answer(Request& request) = 0;
    /// Or the answer that refuses it before it comes.
    virtual tl::expected<BodyRoom, Response> room_for_body(const Request& head) = 0;
    /// Kept as long as a large body is; or the answer to who has none, for there are few of them.
    virtual tl::expected<std::shared_ptr<void>, Response> place_for_body() = 0;
    /// Of a body that is more than usual; nullptr: in memory.
    virtual std::unique_ptr<BodyKeeper> keeper() = 0;
    /// The connection ends with these words.
    virtual void refuse(std::unique_ptr<Stream> stream, const Response& words) = 0;
    /// There is enough of it for one request and its answer.
    virtual bool has_memory() = 0;
    /// The same; who asked a moment ago, and has waited for nobody's answer since, need not ask the system again.
    virtual bool still_has_memory() = 0;
};

/// Reads requests one after the other, each answered before the next is looked at. It lives as long as its connection, unless it is
/// closed. Who sends nothing, takes nothing or speaks nonsense is told or cut off.
class Session : public std::enable_shared_from_this<Session> {
public:
    Session(asio::io_context& io, SessionOwner& owner, std::unique_ptr<Stream> stream, const SessionLimits& limits);

    void start();
    /// Its turn: the request is answered.
    void take_turn();
    /// At once. What makes a streamed answer, or uses a WebSocket, is gone then.
    void close();
    /// The end is near: an answer that is on its way is said to its end, of a stream what comes next; all else ends at once.
    void finish();
    /// Its place is another's. Who is not in the middle of an answer, and may be about to read one, is told by `words`.
    void leave(const Response& words);
    Visitor visitor(ano::TimePoint now) const;
    /// Since when the client has sent too little of a large body; nothing: he sends none.
    std::optional<ano::TimePoint> body_waits_since() const;
    /// Its place is another's who sends one.
    void give_up_body();

private:
    void await_request();
    void read();
    void came(error_code ec, std::size_t size);
    void refuse_for_memory() noexcept;
    void input_ended();
    void hear();
    bool has_room(const Request& head);
    void say_go_on();
    bool puts_body();
    bool has_place_for(std::size_t held);
    void body_came(std::size_t size);
    void put_body(const std::string& fault);
    void answer(Request request);
    void await_answer(std::shared_ptr<void> needed);
    void send(Response response, bool head_only);
    void write();
    void wrote();
    void next_part();
    bool takes_part(bool is_last);
    void wake();
    void refuse(const Response& words);
    void expect_progress();
    void expect_nothing();
    void await_deadline();
    void lost_patience();

    asio::io_context& io_;
    SessionOwner& owner_;
    const SessionLimits& limits_;
    std::unique_ptr<Stream> stream_;    // none: closed, refused or a WebSocket
    asio::steady_timer deadline_;
    std::optional<ano::TimePoint> patient_until_;    // nothing: it need not come on
    bool deadline_runs_ = false;                     // set to then, or earlier
    std::uint32_t user_;
    Party party_;
    std::optional<Access> may_;    // what the request that is answered may, or was last

    Asking asking_ = Asking::unheard;
    bool awaits_turn_ = false;    // with a whole request
    bool reading_ = false;
    bool input_ended_ = false;
    ano::TimePoint since_;         // it came, or came on
    ano::TimePoint whole_at_{};    // the request that is answered, or was last
    std::array<char, 4 * 1024> room_;
    std::string input_;    // what came and is not read yet
    std::optional<RequestReader> reader_;

    Sending sending_;
    std::string head_, body_;    // what is being written, and behind it:
    std::shared_ptr<const std::string> shared_ = nothing_;
    static const std::shared_ptr<const std::string> nothing_;
    std::size_t written_ = 0;
    std::unique_ptr<Producer> producer_;
    bool part_awaited_ = false;      // the producer has none for now
    bool has_length_ = false;        // its answer was told to have
    std::uint64_t to_come_ = 0;      // so many bytes more
    bool answer_awaited_ = false;    // a patient one
    std::shared_ptr<void> needed_;
    BodyRoom room_for_body_;             // of the request that comes, or is answered
    std::optional<Response> refusal_;    // of its body
    bool go_on_awaited_ = false;         // 100 Continue
    bool is_kept_ = false;               // the part of its body that came last is being kept
    std::size_t came_since_ = 0;         // bytes of its body since body_since_
    ano::TimePoint body_since_{};
    std::unique_ptr<BodyKeeper> keeper_;
    bool woken_ = false;
    bool finishes_ = false;
    bool last_part_ = false;    // of a stream, in finish()
    std::weak_ptr<OpenWebSocket> web_socket_;
};

}    // namespace anogate::http
