#include <foxglove/foxglove_socket.hpp>
#include <foxglove/foxglove_streams.hpp>
#include <runtime/gateway.hpp>
#include <watch/watched_record.hpp>

#include <memory>
#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::size_t messages_a_turn = 16 * 1024;    // bytes of messages encoded in one turn of the loop
constexpr int records_a_turn = 512;                   // limits records that lead to no message

}    // namespace

FoxgloveSocket::FoxgloveSocket(FoxgloveStreams& streams, unsigned number, std::string_view subprotocol, DecodedEncoding encoding,
                               const Requester& requester)
    : streams_{streams},
      number_{number},
      subprotocol_{subprotocol},
      encoding_{encoding},
      requester_{requester},
      session_{streams.server_, encoding, streams.decoding_},
      work_{streams.gateway_.alarms(), [this] { work(); }} {}

FoxgloveSocket::~FoxgloveSocket() {
    if (watches_) streams_.watch_.remove(*this);
    if (socket_) streams_.leave(*this);
}

void FoxgloveSocket::opened(http::WebSocket& socket) {
    socket_ = &socket;
    streams_.join(*this);
    send_if_idle();
}

void FoxgloveSocket::heard(std::string_view message, http::WebSocket::Kind kind) {
    if (kind == http::WebSocket::Kind::text) session_.receive(message);
    else session_.receive_binary();
    while (auto question = session_.next_question()) streams_.ask(*this, std::move(*question));
    send_if_idle();
}

void FoxgloveSocket::learn(const FirstFrame& first) {
    socket_->attempt([&] {
        session_.learn(first);
        send_if_idle();
    });
}

void FoxgloveSocket::forget(std::string_view link) {
    socket_->attempt([&] {
        session_.forget(link);
        send_if_idle();
    });
}

void FoxgloveSocket::use(DecodingPtr decoding) {
    socket_->attempt([&] {
        session_.use(std::move(decoding));
        send_if_idle();
    });
}

void FoxgloveSocket::answer(const foxglove::GetParameters& question, const std::vector<foxglove::Parameter>& values) {
    socket_->attempt([&] {
        session_.answer(question, values);
        send_if_idle();
    });
}

void FoxgloveSocket::changed(const std::vector<foxglove::Parameter>& values) {
    socket_->attempt([&] {
        session_.changed(values);
        send_if_idle();
    });
}

void FoxgloveSocket::warn(std::string_view words) {
    socket_->attempt([&] {
        session_.warn(words);
        send_if_idle();
    });
}

void FoxgloveSocket::more() {
    socket_->attempt([this] { send_if_idle(); });
}

void FoxgloveSocket::work() {
    socket_->attempt([this] {
        if (session_.filter_has_changed()) watch_what_is_wanted();
        send_if_idle();
    });
}

// Must not be called from more(): no watcher may be added or removed there.
void FoxgloveSocket::watch_what_is_wanted() {
    const auto filter = session_.pop_filter();
    if (!filter) {
        if (std::exchange(watches_, false)) streams_.watch_.remove(*this);
    } else if (std::exchange(watches_, true)) {
        streams_.watch_.change(*this, *filter);
    } else {
        streams_.watch_.add(*this, *filter);
    }
}

void FoxgloveSocket::send_if_idle() {
    if (socket_->waiting() == 0) send_next_part();
    else if (session_.filter_has_changed()) work_.set_no_later(Clock::now());
}

void FoxgloveSocket::send_next_part() {
    int records = 0;
    while (socket_->waiting() < messages_a_turn) {
        if (auto message = session_.next()) send(std::move(*message));
        else if (records++ == records_a_turn || !read_next()) break;
    }
    if (records > records_a_turn || session_.filter_has_changed()) work_.set_no_later(Clock::now());
}

// False: no frame is waiting.
bool FoxgloveSocket::read_next() {
    if (const auto record = next_record(rest_)) {
        session_.show(as_recorded(*record, *tables_));
        return true;
    }
    auto item = queue.next(Clock::now());
    if (!item) return false;
    if (const auto* lost = std::get_if<LostFrames>(&*item)) session_.lose(*lost);
    else if (auto* tables = std::get_if<WatchQueue::Tables>(&*item)) tables_ = std::move(*tables);
    else {
        batch_ = std::move(std::get<WatchQueue::Batch>(*item));
        rest_ = *batch_;
    }
    return true;
}

void FoxgloveSocket::send(FoxgloveSession::Message message) {
    using Kind = http::WebSocket::Kind;
    const Kind kind = message.is_text ? Kind::text : Kind::binary;
    if (!socket_->send(std::make_shared<const std::string>(std::move(message.data)), kind))
        session_.warn("a message was too long for this connection and was not sent");
}

}    // namespace anogate
