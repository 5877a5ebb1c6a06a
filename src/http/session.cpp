#include <http/seconds_text.hpp>
#include <http/session.hpp>

#include <algorithm>
#include <new>
#include <utility>

namespace anogate::http {
namespace {

using ano::Clock;

constexpr std::size_t some_of_body = 1024;
constexpr unsigned too_many = 429;    // the HTTP status

}    // namespace

const std::shared_ptr<const std::string> Session::nothing_ = std::make_shared<const std::string>();

Session::Session(asio::io_context& io, SessionOwner& owner, std::unique_ptr<Stream> stream, const SessionLimits& limits)
    : io_{io},
      owner_{owner},
      limits_{limits},
      stream_{std::move(stream)},
      deadline_{io},
      user_{stream_->user()},
      client_id_{client_id_of(user_, stream_->connection_info())},
      is_of_network_{stream_->connection_info().is_network} {}

// If memory is short for a client, its connection is closed and the program continues.
template <class Function>
void Session::guarded(Function function) {
    try {
        function();
    } catch (const std::bad_alloc&) {
        close();
    }
}

void Session::start() {
    by_address_ = owner_.may_control(client_id_, nullptr);
    if (by_address_) may_ = Access::control;
    if (!stream_->connection_info().is_encrypted) return await_request();
    if (!owner_.may_begin_handshake(client_id_)) return close();
    awaits_handshake_ = true;
    expect_progress();
    owner_.wait_for_turn(shared_from_this(), client_id_, may_.value_or(Access::open));
}

void Session::close() {
    end_deadline();
    keeper_.reset();
    producer_.reset();
    if (const auto socket = web_socket_.lock()) socket->end();
    if (stream_) stream_->close();
    stream_.reset();
    request_.reset();
    needed_.reset();
    room_for_body_ = {};
}

void Session::finish() {
    const auto socket = web_socket_.lock();
    if (socket && socket->closes_itself()) return;
    const bool has_more = stream_ && asking_ == Asking::whole && !awaits_turn_ && (!part_awaited_ || woken_);
    if (!has_more) return close();
    finishes_ = true;
    sending_.keep_alive = false;
}

void Session::dismiss() {
    if (web_socket_.expired()) finish();
    else close();
}

void Session::leave(const Response& words) {
    const bool is_answered = asking_ == Asking::whole && !awaits_turn_;
    if (!stream_ || asking_ == Asking::nothing || is_answered) return close();
    if (asking_ == Asking::unheard && stream_->connection_info().is_encrypted)
        return close();    // a response would need a handshake
    refuse(words);
}

ClientConnection Session::connection(ano::TimePoint now) const {
    bool stalled = !awaits_turn_ && !part_awaited_ && !answer_awaited_ && now - since_ >= limits_.stalled_after;
    if (const auto socket = web_socket_.lock()) stalled = socket->is_stalled_since(now - limits_.stalled_after);
    const bool lasts = !awaits_turn_ && !streams_ && now - whole_at_ >= limits_.stalled_after;
    return {client_id_, stalled ? Asking::nothing : asking_, since_, may_, by_address_, streams_, lasts};
}

// `input_` may already contain a part of the next request.
void Session::await_request() {
    room_for_body_ = {};
    go_on_awaited_ = false;
    reader_.emplace(limits_.request, [this](Request& head) {
        head.user = user_;
        head.connection_info = stream_->connection_info();
        return has_room(head) ? std::optional{room_for_body_.max_bytes} : std::nullopt;
    });
    expect_progress();
    if (input_.empty()) return read();
    asking_ = Asking::half;
    receive();
}

void Session::expect_progress() {
    since_ = Clock::now();
    patient_until_ = since_ + limits_.patience;
    await_deadline();
}

void Session::expect_nothing() { patient_until_.reset(); }

// The timer may have expired already while its handler waits in the loop: the handler must find no deadline.
void Session::end_deadline() {
    expect_nothing();
    deadline_.cancel();
}

// The timer is not set again on progress: that would cost more than one early expiry, which sets it to the new deadline.
void Session::await_deadline() {
    if (std::exchange(deadline_runs_, true)) return;
    deadline_.expires_at(*patient_until_);
    deadline_.async_wait([weak = weak_from_this()](error_code ec) {
        const auto self = weak.lock();
        if (!self || ec) return;
        self->deadline_runs_ = false;
        if (!self->patient_until_) return;
        const bool is_patient = Clock::now() < *self->patient_until_;
        self->guarded([&] { is_patient ? self->await_deadline() : self->lost_patience(); });
    });
}

// A client that sent an incomplete request still gets an error response.
void Session::lost_patience() {
    if (!stream_ || asking_ != Asking::half) return close();
    if (is_kept_) return refuse(try_again("the disk is too slow for such a large body; try again"));
    const std::string time = seconds_text(limits_.patience);
    refuse(error(408, room_for_body_.place ? "no more of the body was received for " + time
                                           : "the request was not complete within " + time));
}

void Session::read() {
    if (std::exchange(reading_, true)) return;
    stream_->read_some(asio::buffer(room_), [self = shared_from_this()](error_code ec, std::size_t size) {
        self->reading_ = false;
        if (self->stream_) self->guarded([&] { self->came(ec, size); });
    });
}

// While a request is answered, reading only detects the end of the connection: the next request waits.
void Session::came(error_code ec, std::size_t size) {
    if (ec) return ec == asio::error::eof ? input_ended() : close();
    try {
        input_.append(room_.data(), size);
    } catch (const std::bad_alloc&) {
        return refuse_for_memory();
    }
    if (asking_ != Asking::whole) {
        since_ = Clock::now();
        asking_ = Asking::half;
        on_body(size);
        return receive();
    }
    if (!part_awaited_ && !answer_awaited_) return;
    if (input_.size() <= limits_.request.header) return read();
    if (part_awaited_) return close();    // no error can be sent within a stream
    refuse(error(431, "more than " + std::to_string(limits_.request.header) +
                          " bytes were received after a request that is not answered yet"));
}

void Session::on_body(std::size_t size) {
    if (!room_for_body_.place) return;
    expect_progress();
    came_since_ += size;
    if (came_since_ < some_of_body) return;
    came_since_ = 0;
    body_since_ = since_;
}

std::optional<ano::TimePoint> Session::body_waits_since() const {
    const bool sends = stream_ && room_for_body_.place && asking_ == Asking::half && !is_kept_;
    return sends && Clock::now() - body_since_ >= limits_.slow_body ? std::optional{body_since_} : std::nullopt;
}

void Session::abort_body() {
    refuse(error(408,
                 "the body was received too slowly for " + seconds_text(limits_.slow_body) + ", and another request is waiting"));
}

// The client may still read a response. But if a part of a stream or a later response is awaited, it may never be made, and a
// client that is gone would not be noticed: the connection is closed.
void Session::input_ended() {
    input_ended_ = true;
    if (asking_ == Asking::half) return refuse(error(400, "the request ended before it was complete"));
    if (asking_ != Asking::whole || part_awaited_ || answer_awaited_) close();
}

void Session::receive() {
    if (!owner_.has_memory()) return refuse_for_memory();
    try {
        if (!reader_->is_done()) input_.erase(0, reader_->put(input_));
    } catch (const std::bad_alloc&) {
        return refuse_for_memory();
    }
    if (refusal_) return refuse(*std::exchange(refusal_, std::nullopt));
    if (const auto& fault = reader_->fault()) return refuse(error(fault->status, fault->words));
    if (std::exchange(go_on_awaited_, false) && !reader_->is_done() && reader_->body_size() == 0 && input_.empty())
        return send_continue();
    if (stores_body()) return;
    if (!reader_->is_done()) return read();
    asking_ = Asking::whole;
    whole_at_ = Clock::now();
    awaits_turn_ = true;
    expect_nothing();
    try {
        on_request();
    } catch (const std::bad_alloc&) {
        return refuse_for_memory();
    }
    if (const auto words = owner_.refusal_if_full(client_id_, *may_)) return refuse(*words);
    owner_.wait_for_turn(shared_from_this(), client_id_, *may_);
}

// The request is judged before its turn, since the order of turns depends on its access.
void Session::on_request() {
    Request& request = request_.emplace(reader_->pop_request());
    request.user = user_;
    request.connection_info = stream_->connection_info();
    request.came_at = whole_at_;
    request.judged = room_for_body_.judged;
    if (keeper_) request.stored = keeper_->whole();
    keeper_.reset();
    auto access = owner_.judge(request);
    token_ = std::move(request.token);
    may_ = request.access = access.value_or(Access::open);
    by_address_ = false;
    if (!access) unanswered_ = std::move(access.error());
    also_ = std::move(request.also);
}

// Called once per request; stores its access if it is judged here, so that it is not judged twice.
bool Session::has_room(Request& head) {
    if (owner_.may_control(client_id_, &head)) {
        may_ = Access::control;
        by_address_ = false;
    }
    auto room = owner_.room_for_body(head);
    if (!room) refusal_ = std::move(room.error());
    else room_for_body_ = std::move(*room);
    body_since_ = Clock::now();
    came_since_ = 0;
    go_on_awaited_ = head.version == 11 && head.header_has("Expect", "100-continue");
    return !refusal_;
}

// The client waits for this before it sends the body (RFC 9110, 10.1.1).
void Session::send_continue() {
    static constexpr std::string_view words = "HTTP/1.1 100 Continue\r\n\r\n";
    stream_->write_some({asio::buffer(words.substr(written_))}, [self = shared_from_this()](error_code ec, std::size_t size) {
        if (!self->stream_) return;
        if (ec) return self->close();
        self->written_ += size;
        const bool is_sent = self->written_ == words.size();
        if (is_sent) self->written_ = 0;
        self->guarded([&] { is_sent ? self->read() : self->send_continue(); });
    });
}

// A chunked body counts as large once more than RequestLimits::body of it was received.
bool Session::has_place_for(std::size_t held) {
    if (!room_for_body_.place && held > limits_.request.body) {
        auto place = owner_.place_for_body();
        if (!place) refusal_ = std::move(place.error());
        else room_for_body_.place = std::move(*place);
        body_since_ = Clock::now();
    }
    return room_for_body_.place != nullptr;
}

// A large body is passed to its keeper in parts; nothing is read while the keeper stores one.
bool Session::stores_body() {
    const std::size_t size = reader_->body_size();
    if (!has_place_for(size)) {
        if (refusal_) refuse(*std::exchange(refusal_, std::nullopt));
        return stream_ == nullptr;
    }
    const std::size_t held = reader_->is_done() ? (keeper_ ? 0 : limits_.request.body) : limits_.part_of_body - 1;
    if (size <= held) return false;
    if (!keeper_) keeper_ = owner_.keeper();
    if (!keeper_) return false;
    is_kept_ = true;
    keeper_->put(reader_->pop_body(),
                 [self = shared_from_this()](const std::string& fault) { self->guarded([&] { self->store_body(fault); }); });
    return true;
}

void Session::store_body(const std::string& fault) {
    is_kept_ = false;
    if (!stream_) return;
    if (!fault.empty()) return refuse(error(507, fault));
    expect_progress();
    body_since_ = since_;
    receive();
}

void Session::run_turn() {
    if (const auto socket = web_socket_.lock()) return socket->run_turn();
    if (!stream_) return;
    if (std::exchange(awaits_handshake_, false)) return stream_->has_left() ? close() : await_request();
    if (!owner_.still_has_memory()) return refuse_for_memory();
    awaits_turn_ = false;
    expect_progress();
    try {
        Request request = *std::exchange(request_, std::nullopt);
        answer(request);
    } catch (const std::bad_alloc&) {
        if (stream_) refuse_for_memory();
    }
}

void Session::answer(Request& request) {
    sending_ = {request.version, request.keep_alive};
    const bool head_only = request.method == "HEAD";
    const bool guesses = unanswered_ || request.slowed > ano::Duration{};
    auto no_answer = std::exchange(unanswered_, std::nullopt);
    Response response = no_answer ? std::move(*no_answer) : owner_.answer(request);
    if (!stream_) return;                            // the function of the route has closed this session
    if (guesses && response.status == too_many) {    // the connection is closed: each further guess needs a new one
        if (also_) response.headers.push_back(*std::exchange(also_, std::nullopt));
        return refuse(response);
    }
    const bool has_end = response.length || request.method == "POST";    // that of a job ends
    const bool streams = response.web_socket || (response.producer && !has_end);
    if (streams || response.patient)
        if (auto no = owner_.refusal_if_no_place(client_id_, request.access, streams)) return send(std::move(*no), head_only);
    streams_ = streams;
    if (response.web_socket) {
        Response fault = web_socket_fault(request);
        if (fault.status == 200 && reading_) fault = error(400, "a WebSocket can't follow a stream on the same connection");
        if (fault.status == 200) {
            end_deadline();
            web_socket_ = open_web_socket(io_, std::move(stream_), request, std::move(input_), std::move(response.web_socket),
                                          limits_.web_socket, shared_from_this(), turns_of_web_socket());
            return;
        }
        response = std::move(fault);
        streams_ = false;
    }
    if (!response.later) return send(std::move(response), head_only);
    if (response.patient) {
        await_answer(std::move(response.needed));    // the pending read keeps this session alive until the client is gone
        return response.later([weak = weak_from_this(), head_only](Response known) {
            if (const auto self = weak.lock(); self && self->stream_)
                self->guarded([&] { self->send(std::move(known), head_only); });
        });
    }
    response.later([self = shared_from_this(), head_only](Response known) {    // nothing else keeps this session alive meanwhile
        if (self->stream_) self->guarded([&] { self->send(std::move(known), head_only); });
    });
}

// A message may cost as much as a request, so it waits for a turn. Messages of clients that may control are processed at once.
std::function<void()> Session::turns_of_web_socket() {
    if (may() == Access::control) return {};
    return [weak = weak_from_this()] {
        if (auto self = weak.lock()) self->owner_.wait_for_turn(self, self->client_id_, self->may());
    };
}

// read() shows whether the client is still there.
void Session::await_answer(std::shared_ptr<void> needed) {
    expect_nothing();
    answer_awaited_ = true;
    needed_ = std::move(needed);
    read();
}

void Session::send(Response response, bool head_only) {
    if (std::exchange(answer_awaited_, false)) expect_progress();
    needed_.reset();
    if (also_) response.headers.push_back(*std::exchange(also_, std::nullopt));
    if (response.producer && !response.length && sending_.version == 10)
        sending_.keep_alive = false;    // HTTP/1.0: closing the connection ends the body
    sending_.chunked = response.producer && !response.length && sending_.version != 10;
    has_length_ = response.length.has_value();
    to_come_ = response.length.value_or(0);
    head_ = head_of(response, sending_);
    if (!head_only) {
        body_ = std::move(response.body);
        if (response.shared) shared_ = std::move(response.shared);
        producer_ = std::move(response.producer);
    }
    if (producer_)
        producer_->start([weak = weak_from_this()] {
            if (const auto self = weak.lock()) self->wake();
        });
    write();
}

void Session::write() {
    const std::size_t of_head = std::min(written_, head_.size()), of_body = std::min(written_ - of_head, body_.size());
    stream_->write_some(
        {asio::buffer(head_) + of_head, asio::buffer(body_) + of_body, asio::buffer(*shared_) + (written_ - of_head - of_body)},
        [self = shared_from_this()](error_code ec, std::size_t size) {
            if (!self->stream_) return;
            if (ec) return self->close();
            self->written_ += size;
            self->guarded([&self] { self->wrote_some(); });
        });
}

void Session::wrote_some() {
    if (written_ == head_.size() + body_.size() + shared_->size()) return wrote();
    expect_progress();
    write();
}

void Session::wrote() {
    head_.clear();
    body_.clear();
    shared_ = nothing_;
    written_ = 0;
    if (producer_) return next_part();
    body_ = std::string{};    // releases the buffer while the connection is idle
    asking_ = Asking::nothing;
    streams_ = false;
    if (sending_.keep_alive) return await_request();
    stream_->end_output();
    close();
}

void Session::next_part() {
    if (last_part_) return close();
    last_part_ = finishes_;
    const Producer::Next next = producer_->next(body_);
    if (!stream_) return;
    if (next == Producer::Next::end) producer_.reset();
    if (!sends_part(producer_ == nullptr)) return close();
    if (next == Producer::Next::part && body_.empty()) return next_part_soon();
    if (sending_.chunked && !body_.empty()) body_ = chunk(body_);
    if (sending_.chunked && !producer_) body_ += last_chunk;
    part_awaited_ = next == Producer::Next::later && body_.empty();
    if (part_awaited_) {
        expect_nothing();
        return input_ended_ || finishes_ ? close() : read();    // read() shows whether the client is still there
    }
    expect_progress();
    write();
}

void Session::next_part_soon() {
    expect_progress();
    asio::post(io_, [self = shared_from_this()] {
        if (self->stream_) self->guarded([&] { self->next_part(); });
    });
}

// False: the producer's data do not match the length in the header; the client can only be informed by closing the connection.
bool Session::sends_part(bool is_last) {
    if (!has_length_) return true;
    if (body_.size() > to_come_) return false;
    to_come_ -= body_.size();
    return !is_last || to_come_ == 0;
}

// May be called from anywhere, also from within next(). So the producer is called from the loop.
void Session::wake() {
    if (std::exchange(woken_, true)) return;
    try {
        asio::post(io_, [weak = weak_from_this()] {
            const auto self = weak.lock();
            if (!self) return;
            self->woken_ = false;
            if (self->stream_ && std::exchange(self->part_awaited_, false)) self->guarded([&self] { self->next_part(); });
        });
    } catch (const std::bad_alloc&) {
        woken_ = false;
        if (stream_) stream_->close();    // the pending operation fails, and that ends the session
    }
}

void Session::refuse_for_memory() noexcept {
    try {
        refuse(try_again("not enough memory for a request; try again"));
    } catch (const std::bad_alloc&) {
        close();
    }
}

void Session::refuse(const Response& words) {
    end_deadline();
    keeper_.reset();
    producer_.reset();
    request_.reset();
    needed_.reset();
    room_for_body_ = {};
    stream_->cancel();
    owner_.refuse(std::move(stream_), words);
}

}    // namespace anogate::http
