#include <link/tcp/tcp_session.hpp>
#include <link/tcp/tcp_socket.hpp>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace anogate {
namespace {

constexpr Duration look_again = std::chrono::milliseconds{20};
constexpr Duration patience_in_group = std::chrono::seconds{1};

}    // namespace

TcpSession::TcpSession(const LinkContext& context, const LinkSettings& link, Duration dead_after)
    : StreamSession{context},
      dead_after_{dead_after},
      max_age_{std::max(link.age.rest, patience_in_group)},
      step_{context.io},
      handshake_ends_{context.alarms,
                      [this] {
                          if (!is_opening()) return;
                          is_late_ = true;
                          failed(ETIMEDOUT);
                      }},
      read_on_{context.alarms, [this] { read_again(); }},
      write_on_{context.alarms, [this] { write(); }},
      give_up_{context.alarms, [this] { give_up_if_silent(); }} {}

TcpSession::~TcpSession() { step_.stop(ano::TimePoint::min()); }

void TcpSession::encrypt_by(std::shared_ptr<TlsConnection> tls) {
    step_.stop(ano::TimePoint::min());
    handshake_.reset();
    tls_ = std::move(tls);
    is_late_ = needs_record_ = false;
    handshake_ends_.cancel();
}

void TcpSession::close() noexcept {
    handshake_ends_.cancel();
    read_on_.cancel();
    write_on_.cancel();
    give_up_.cancel();
    in_flight_limit_ = {};
    step_.stop(ano::TimePoint::min());
    unacknowledged_ = {};
    gave_up_after_.reset();
    StreamSession::close();
}

std::string TcpSession::tls_fault() const {
    if (!tls_) return {};
    return is_late_ ? "the TLS handshake did not finish within 10 s" : tls_->fault();
}

StreamSession::Opening TcpSession::go_on_opening() {
    if (!tls_ || (!step_.is_running() && tls_->is_done())) return Opening::done;
    if (!handshake_ends_.is_set()) handshake_ends_.set(context_.host.now() + handshake_patience);
    if (needs_record_ && !tls_->has_record()) return Opening::wants_to_read;
    needs_record_ = false;
    if (!handshake_ && begin_step()) return Opening::waits;
    if (!handshake_) handshake_ = tls_->go_on();
    switch (*std::exchange(handshake_, std::nullopt)) {
    case TlsConnection::Handshake::wants_to_read: needs_record_ = true; return Opening::wants_to_read;
    case TlsConnection::Handshake::wants_to_write: return Opening::wants_to_write;
    case TlsConnection::Handshake::done: handshake_ends_.cancel(); return Opening::done;
    case TlsConnection::Handshake::failed: break;
    }
    handshake_ends_.cancel();
    errno = ECONNABORTED;
    return Opening::failed;
}

std::size_t TcpSession::not_acknowledged() const {
    if (!is_open()) return 0;
    return unacknowledged(fd()) + (tls_ && !is_opening() ? tls_->unsent() : 0);
}

std::chrono::milliseconds TcpSession::not_acknowledged_for() const {
    const TimePoint now = context_.host.now();
    unacknowledged_.see(not_acknowledged(), now);
    return std::chrono::duration_cast<std::chrono::milliseconds>(unacknowledged_.age(now));
}

// Frames in the kernel must not be delivered when they are stale, nor long after newer frames that another link of the group
// delivers, and not at all after a newer command.
Duration TcpSession::patience(Duration age) {
    if (!context_.host.has_connected_mate(channel())) return std::min(dead_after_, max_age_);
    const bool is_overtaken = is_interrupted() && context_.host.has_newer_command_of_mate(channel(), context_.host.now() - age);
    return is_overtaken ? Duration{} : std::min(dead_after_, patience_in_group);
}

Duration TcpSession::between_looks() {
    return context_.host.has_connected_mate(channel()) ? look_again : std::min(dead_after_, patience_in_group);
}

bool TcpSession::is_interrupted() {
    return unacknowledged_.may_be_interrupted(context_.host.now(), [this] { return round_trip(fd()); });
}

// A connection whose peer does not read is closed by the kernel, after dead_after.
void TcpSession::give_up_if_silent() {
    if (!is_open() || is_opening() || not_acknowledged() == 0) return;
    const Duration age = not_acknowledged_for();
    const Duration longest = std::max<Duration>(patience(age), 4 * round_trip(fd()).now);
    if (age < longest) {
        if (is_interrupted()) acknowledges_nothing();
        return give_up_.set(context_.host.now() + std::min(longest - age, between_looks()));
    }
    if (waits_for_reader(fd())) return give_up_.set(context_.host.now() + std::max<Duration>(longest, look_again));
    gave_up_after_ = age;
    abort_connection(fd());
    failed(ETIMEDOUT);
}

bool TcpSession::begin_step() {
    const auto result = std::make_shared<TlsConnection::Handshake>(TlsConnection::Handshake::failed);
    return step_.run([tls = tls_, result] { *result = tls->go_on(); },
                     [this, result](const std::string&) {
                         if (!is_opening()) return;
                         handshake_ = *result;
                         continue_opening();
                     });
}

ssize_t TcpSession::read_some(std::span<std::uint8_t> room) {
    if (!tls_) return StreamSession::read_some(room);
    const ssize_t n = tls_->read(room);
    if (n > 0 && tls_->has_more()) read_on_.set(context_.host.now());
    return n;
}

bool TcpSession::waits_for_acknowledgement() {
    const TimePoint now = context_.host.now();
    const auto measure = [this] { return round_trip(fd()); };
    Duration wait = in_flight_limit_.wait(unacknowledged_.bytes(), now, measure);
    if (unacknowledged_.may_be_interrupted(now, measure)) {
        acknowledges_nothing();    // at once: frames that wait here are lost with the connection
        wait = look_again;
    }
    if (wait > Duration::zero()) write_on_.set(now + wait);
    else write_on_.cancel();
    return write_on_.is_set();
}

void TcpSession::write_later() {
    if (!write_on_.is_set()) StreamSession::write_later();
}

ssize_t TcpSession::write_some(std::span<const iovec> pieces) {
    not_acknowledged_for();
    std::size_t bytes = not_sent(fd());
    if (!pieces.empty() && (waits_for_acknowledgement() || bytes >= max_not_sent)) {
        errno = EAGAIN;
        return -1;
    }
    std::size_t count = 0;
    while (count < pieces.size() && (count == 0 || bytes + pieces[count].iov_len <= max_not_sent))
        bytes += pieces[count++].iov_len;
    const ssize_t n = tls_ ? tls_->write(pieces.first(count)) : StreamSession::write_some(pieces.first(count));
    if (n > 0) unacknowledged_.wrote(static_cast<std::size_t>(n), context_.host.now());
    if (n > 0 && !give_up_.is_set()) give_up_.set(context_.host.now() + between_looks());
    return n;
}

}    // namespace anogate
