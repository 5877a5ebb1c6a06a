#include <sys/asio.hpp>

#include <http/open_web_socket.hpp>
#include <http/send_queue.hpp>

#include <boost/beast/core/bind_handler.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <algorithm>
#include <functional>
#include <new>
#include <utility>

namespace anogate::http {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

// Adapts a Stream to Beast's requirements; returns the bytes in `early` first.
class Under {
public:
    using executor_type = asio::io_context::executor_type;

    Under(asio::io_context& io, std::unique_ptr<Stream> stream, std::string early)
        : io_{&io}, stream_{std::move(stream)}, early_{std::move(early)} {}

    executor_type get_executor() const noexcept { return io_->get_executor(); }
    Stream& stream() { return *stream_; }
    ano::TimePoint written_at() const { return written_at_; }
    std::uint64_t reads() const noexcept { return reads_; }

    template <class Buffers, class Handler>
    void async_read_some(const Buffers& into, Handler&& handler) {
        asio::mutable_buffer room;
        for (auto it = asio::buffer_sequence_begin(into); it != asio::buffer_sequence_end(into) && room.size() == 0; ++it)
            room = *it;
        if (early_.empty())
            return stream_->read_some(room, [this, done = done(std::forward<Handler>(handler))](error_code ec, std::size_t size) {
                ++reads_;    // `done` keeps the owner of this object alive
                done(ec, size);
            });
        const std::size_t size = asio::buffer_copy(room, asio::buffer(early_));
        early_.erase(0, size);
        asio::post(*io_, [done = done(std::forward<Handler>(handler)), size] { done({}, size); });
    }

    template <class Buffers, class Handler>
    void async_write_some(const Buffers& from, Handler&& handler) {
        Stream::Parts parts;
        std::size_t count = 0;
        for (auto it = asio::buffer_sequence_begin(from); it != asio::buffer_sequence_end(from) && count < parts.size(); ++it)
            if (const asio::const_buffer part = *it; part.size() > 0) parts[count++] = part;
        stream_->write_some(parts, [this, done = done(std::forward<Handler>(handler))](error_code ec, std::size_t size) {
            written_at_ = ano::Clock::now();
            done(ec, size);
        });
    }

private:
    // Beast's handlers can only be moved, but Stream::Done must be copyable.
    template <class Handler>
    static Stream::Done done(Handler&& handler) {
        auto held = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
        return [held](error_code ec, std::size_t size) {
            try {
                std::move (*held)(ec, size);
            } catch (const std::bad_alloc&) {}    // this operation of Beast is lost; the WebSocket ends with its other one
        };
    }

    asio::io_context* io_;
    std::unique_ptr<Stream> stream_;
    std::string early_;
    ano::TimePoint written_at_ = ano::Clock::now();
    std::uint64_t reads_ = 0;
};

// Found by Beast through argument-dependent lookup.
void beast_close_socket(Under& under) { under.stream().close(); }

template <class Handler>
void async_teardown(beast::role_type, Under& under, Handler&& handler) {
    under.stream().end_output();
    asio::post(under.get_executor(), beast::bind_handler(std::forward<Handler>(handler), error_code{}));
}

beast::http::request<beast::http::empty_body> beasts(const Request& request) {
    beast::http::request<beast::http::empty_body> same{beast::http::verb::get, request.target, request.version};
    for (const Field& field : request.headers) same.insert(field.name, field.value);
    return same;
}

std::string format_close(const error_code& ec, const websocket::close_reason& received) {
    if (ec == websocket::error::closed)
        return received.reason.empty() ? "closed by the gateway"
                                       : "closed by the gateway: " + std::string{received.reason.c_str()};
    if (ec == asio::error::eof || ec == asio::error::connection_reset || ec == asio::error::broken_pipe)
        return "the gateway closed the connection";
    if (ec == beast::error::timeout) return "the gateway no longer responds";
    return ec.message();
}

class BeastWebSocket final : public OpenWebSocket, public std::enable_shared_from_this<BeastWebSocket> {
public:
    BeastWebSocket(asio::io_context& io, std::unique_ptr<Stream> stream, std::string early, std::unique_ptr<WebSocketUser> user,
                   const WebSocketLimits& limits, std::shared_ptr<void> place, std::function<void()> wait_for_turn = {})
        : socket_{io, std::move(stream), std::move(early)},
          limits_{limits},
          queue_{limits.queue},
          stuck_{io},
          user_{std::move(user)},
          place_{std::move(place)},
          wait_for_turn_{std::move(wait_for_turn)} {}

    void open(const Request& request) {
        prepare(limits_.stuck);
        socket_.set_option(websocket::stream_base::decorator(
            [subprotocol = std::string{user_->subprotocol()}](websocket::response_type& response) {
                response.set(beast::http::field::server, "anogate");
                if (!subprotocol.empty()) response.set(beast::http::field::sec_websocket_protocol, subprotocol);
            }));
        socket_.async_accept(beasts(request), [self = shared_from_this()](error_code ec) {
            if (!self->user_) return;
            if (ec) return self->end();
            self->guarded([&self] { self->begin(); });
        });
    }

    void join(const Request& request, ano::Duration patience, std::function<void(Outcome)> ended) {
        ended_ = std::move(ended);
        prepare(patience);
        socket_.set_option(websocket::stream_base::decorator([headers = request.headers](websocket::request_type& asked) {
            for (const Field& field : headers) asked.insert(field.name, field.value);
        }));
        const auto answer = std::make_shared<websocket::response_type>();
        socket_.async_handshake(*answer, "anogate", request.target, [self = shared_from_this(), answer](error_code ec) {
            if (!self->user_) return;
            if (ec && ec != websocket::error::upgrade_declined) return self->end_for(ec);
            self->answer_.status = answer->result_int();
            for (const auto& field : *answer)
                self->answer_.headers.push_back({std::string{field.name_string()}, std::string{field.value()}});
            self->answer_.body = std::move(answer->body());
            if (ec) self->end_for({});
            else self->guarded([&self] { self->begin(); });
        });
    }

    bool send(Message message, Kind kind) override {
        if (!user_ || closing_) return false;
        bool is_taken = false;
        attempt([&] {
            is_taken = queue_.push(std::move(message), kind);
            if (is_taken && !writing_) write();
        });
        return is_taken && !closing_;
    }
    std::size_t waiting() const noexcept override { return queue_.bytes(); }
    std::uint64_t reads() const noexcept override { return socket_.next_layer().reads(); }

    void close(std::uint16_t code, std::string_view reason) override {
        if (!user_ || std::exchange(closing_, true)) return;
        begun_at_ = ano::Clock::now();
        constexpr std::size_t max_reason = 123;    // bytes that fit into a control frame
        websocket::close_reason why{websocket::close_code{code}};
        why.reason.assign(reason.data(), std::min(reason.size(), max_reason));
        attempt([&] {
            watch();
            socket_.async_close(why, [self = shared_from_this()](error_code) { self->end_for({}); });
        });
    }

    void end() override {
        if (!user_) return;
        ended_ = {};
        stuck_.cancel();
        socket_.next_layer().stream().close();
        if (!writing_) queue_.clear();    // otherwise the write in progress still needs the queue
        place_.reset();
        waits_.reset();    // the caller keeps this object alive
        const auto user = std::move(user_);
        user_.reset();
    }

    bool closes_itself() const override { return user_ && user_->closes_itself(); }

    bool is_stalled_since(ano::TimePoint time) const override {
        return (writing_ || closing_) && std::max(begun_at_, socket_.next_layer().written_at()) < time;
    }

    void run_turn() override {
        const auto self = std::exchange(waits_, nullptr);
        if (user_) guarded([this] { heard(); });
    }

private:
    void prepare(ano::Duration handshake) {
        websocket::stream_base::timeout patience{};
        patience.handshake_timeout = handshake;
        patience.idle_timeout = user_->idle(limits_.idle);
        patience.keep_alive_pings = true;
        socket_.set_option(patience);
        socket_.read_message_max(limits_.message);
        socket_.auto_fragment(false);    // a message is one frame
    }

    void begin() {
        read();
        const auto user = user_;    // keeps the user alive: it may end this WebSocket
        user->opened(*this);
    }

    // If memory is short for a client, its connection is closed and the program continues.
    template <class Function>
    void guarded(Function function) {
        try {
            function();
        } catch (const std::bad_alloc&) {
            end_for({});
        }
    }

    // The pending read, or the next one, fails and ends the connection.
    void abandon() noexcept override {
        closing_ = true;
        socket_.next_layer().stream().close();
    }

    // For an end that was not caused by end(): calls ended_.
    void end_for(const error_code& ec) {
        if (!user_) return;
        const auto ended = std::move(ended_);
        end();
        if (ended) ended({ec ? format_close(ec, socket_.reason()) : std::string{}, std::move(answer_)});
    }

    void read() {
        socket_.async_read(buffer_, [self = shared_from_this()](error_code ec, std::size_t) {
            if (!self->user_) return;
            if (ec) return self->end_for(ec);
            self->guarded([&self] { self->wait_for_turn_ ? self->wait() : self->heard(); });
        });
    }

    // No read is pending that would keep this object alive, so waits_ does.
    void wait() {
        waits_ = shared_from_this();
        wait_for_turn_();
    }

    void heard() {
        const auto user = user_;
        const auto data = buffer_.cdata();
        if (!closing_)
            user->heard({static_cast<const char*>(data.data()), data.size()}, socket_.got_text() ? Kind::text : Kind::binary);
        buffer_.clear();
        if (user_) read();
    }

    void write() {
        writing_ = true;
        begun_at_ = ano::Clock::now();
        watch();
        const SendQueue::Entry& entry = queue_.front();
        socket_.text(entry.kind == Kind::text);
        socket_.async_write(asio::buffer(*entry.message), [self = shared_from_this()](error_code ec, std::size_t) {
            self->writing_ = false;
            if (!self->user_) return;
            if (ec) return self->end_for(ec);
            self->queue_.pop();
            if (!self->closing_) self->guarded([&self] { self->wrote(); });
        });
    }

    void wrote() {
        if (!queue_.empty()) return write();
        const auto user = user_;
        user->sent_all();
    }

    // The timer runs as long as data are being sent; it is not set again for each write.
    void watch() {
        if (std::exchange(watching_, true)) return;
        stuck_.expires_at(std::max(begun_at_, socket_.next_layer().written_at()) + limits_.stuck);
        stuck_.async_wait([weak = weak_from_this()](error_code) {
            const auto self = weak.lock();
            if (!self) return;
            self->watching_ = false;
            if (!self->user_ || (!self->writing_ && !self->closing_)) return;
            if (self->is_stalled_since(ano::Clock::now() - self->limits_.stuck)) return self->end_for(beast::error::timeout);
            self->guarded([&self] { self->watch(); });
        });
    }

    websocket::stream<Under, false> socket_;
    beast::flat_buffer buffer_;
    const WebSocketLimits limits_;
    SendQueue queue_;
    asio::steady_timer stuck_;
    ano::TimePoint begun_at_{};
    bool writing_ = false;
    bool closing_ = false;
    bool watching_ = false;
    std::shared_ptr<WebSocketUser> user_;    // nullptr: ended
    std::function<void(Outcome)> ended_;     // on the client's side
    Answer answer_;                          // on the client's side: the response to the request
    std::shared_ptr<void> place_;
    const std::function<void()> wait_for_turn_;
    std::shared_ptr<BeastWebSocket> waits_;    // this object, as long as a message waits for its turn
};

}    // namespace

std::shared_ptr<OpenWebSocket> open_web_socket(asio::io_context& io, std::unique_ptr<Stream> stream, const Request& request,
                                               std::string early, std::unique_ptr<WebSocketUser> user,
                                               const WebSocketLimits& limits, std::shared_ptr<void> place,
                                               std::function<void()> wait_for_turn) {
    auto socket = std::make_shared<BeastWebSocket>(io, std::move(stream), std::move(early), std::move(user), limits,
                                                   std::move(place), std::move(wait_for_turn));
    socket->open(request);
    return socket;
}

std::shared_ptr<OpenWebSocket> join_web_socket(asio::io_context& io, std::unique_ptr<Stream> stream, const Request& request,
                                               std::unique_ptr<WebSocketUser> user, const WebSocketLimits& limits,
                                               ano::Duration patience, std::function<void(Outcome)> ended) {
    auto socket = std::make_shared<BeastWebSocket>(io, std::move(stream), std::string{}, std::move(user), limits, nullptr);
    socket->join(request, patience, std::move(ended));
    return socket;
}

}    // namespace anogate::http
