#include <link/stream_session.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace anogate {
namespace {

constexpr std::size_t frames_per_write = 64;
constexpr int reads_per_turn = 16;    // before other links have their turn
constexpr std::size_t max_raw = 64 * 1024;

}    // namespace

StreamSession::StreamSession(const LinkContext& context)
    : context_{context},
      descriptor_{context.io},
      expiry_{context.alarms,
              [this] {
                  channel_->parser.expire(context_.host.now());
                  deliver();
                  if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
              }},
      pacing_{context.alarms, [this] { write(); }} {}

void StreamSession::translate(const V7LinkSettings& v7, const LinkSettings& link) {
    if (v7.is_on())
        v7_ = std::make_unique<V7Edge>(v7, link, context_,
                                       V7Edge::Calls{[this] { write(); }, [this](ano::FrameView frame) { receive(frame); }});
}

void StreamSession::open(UniqueFd fd, Channel& channel) {
    channel_ = &channel;
    if (v7_) v7_->begin(channel);
    descriptor_.open(std::move(fd));
    is_opening_ = true;
    continue_opening();
}

void StreamSession::continue_opening() {
    switch (go_on_opening()) {
    case Opening::done: break;
    case Opening::wants_to_read: return descriptor_.read_with([this] { read(); });
    case Opening::wants_to_write: descriptor_.stop_reading(); return descriptor_.when_writable([this] { continue_opening(); });
    case Opening::waits: return descriptor_.stop_reading();
    case Opening::failed: return failed(errno);
    }
    is_opening_ = false;
    begin_input();
    opened();
}

void StreamSession::begin_input() {
    const ClockReading now = context_.host.turn().clocks();
    begin_arrival(arrival_, fd(), stored_ ? &*stored_ : nullptr, now);
    if (!stored_) return;
    const StoredLink stored = *std::exchange(stored_, std::nullopt);
    if (v7_ && stored.rest.empty()) return;
    const auto room = v7_ ? v7_->prepare() : channel_->parser.prepare();
    const std::size_t size = std::min(stored.rest.size(), room.size());
    std::copy_n(stored.rest.begin(), size, room.begin());
    channel_->arrived_at = stored.unread_since.now;
    if (v7_) v7_->commit(size, now.now);
    else channel_->parser.commit(size, now.now);    // the rest may already be waiting on the wire
    expiry_.set(now.now);    // frames after a false header are delivered later, when the other links are up
}

void StreamSession::close() noexcept {
    descriptor_.close();
    pacing_.stop();
    expiry_.cancel();
    raw_.clear();
    is_opening_ = false;
    if (v7_) v7_->pause();
}

void StreamSession::resume_reading() {
    descriptor_.read_with([this] { read(); });
}

void StreamSession::end_of_input() {
    if (v7_) {
        v7_->end_of_input();
        context_.host.flush();
        raw_.clear();
        return;
    }
    expiry_.cancel();
    channel_->parser.finish();
    deliver();
}

ssize_t StreamSession::read_some(std::span<std::uint8_t> room) { return ::read(fd(), room.data(), room.size()); }

void StreamSession::read() {
    if (is_opening_) return continue_opening();
    for (int i = 0; i < reads_per_turn; ++i) {
        const auto room = v7_ ? v7_->prepare() : channel_->parser.prepare();
        const ssize_t n = read_some(room);
        const int error = n < 0 ? errno : 0;
        if (error == EINTR) break;
        if (n <= 0) arrival_.found_empty(context_.host.turn().before());
        if (error == EAGAIN) break;
        if (n <= 0) return read_ended(error);
        const StallDetector& loop = context_.host.turn();
        channel_->arrived_at = arrival_.unstamped(loop);
        if (v7_) v7_->commit(static_cast<std::size_t>(n), loop.now());
        else channel_->parser.commit(static_cast<std::size_t>(n), loop.now());
        if (tap_) [[unlikely]]
            tap_->received(room.first(static_cast<std::size_t>(n)));
        deliver();
        if (!is_open()) return;
        if (static_cast<std::size_t>(n) < room.size() && !arrival_.is_behind()) break;    // a terminal read returns at most 4 KB
    }
    if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
}

void StreamSession::deliver() {
    if (v7_) {
        v7_->deliver();
        context_.host.flush();
        return write();
    }
    while (const auto frame = channel_->parser.next()) receive(*frame);
    context_.host.flush();
}

ssize_t StreamSession::write_some(std::span<const iovec> pieces) {
    return ::writev(fd(), pieces.data(), static_cast<int>(pieces.size()));
}

void StreamSession::write_later() {
    descriptor_.when_writable([this] { write(); });
}

void StreamSession::pass_to_tap(std::span<const std::span<const std::uint8_t>> frames, std::size_t bytes) {
    for (const auto frame : frames) {
        if (bytes == 0) return;
        const std::size_t taken = std::min(bytes, frame.size());
        tap_->sent(frame.first(taken));
        bytes -= taken;
    }
}

bool StreamSession::write_raw(std::span<const std::uint8_t> bytes) {
    if (!is_open() || is_opening_ || raw_.size() + bytes.size() > max_raw) return false;
    raw_.insert(raw_.end(), bytes.begin(), bytes.end());
    write();
    return true;
}

// Waits until a partly sent frame is complete. False: nothing more can be written now, or the connection is lost.
bool StreamSession::write_raw_first() {
    while (!raw_.empty() && !channel_->outbox.has_begun()) {
        const iovec piece{raw_.data(), raw_.size()};
        const ssize_t n = write_some({&piece, 1});
        if (n > 0) {
            const std::span<const std::uint8_t> taken{raw_.data(), static_cast<std::size_t>(n)};
            if (tap_) tap_->sent(taken);
            raw_.erase(raw_.begin(), raw_.begin() + n);
            pacing_.sent(static_cast<std::size_t>(n), context_.host.now());
        } else if (n == 0 || errno == EAGAIN) {
            write_later();
            return false;
        } else if (errno != EINTR) {
            failed(errno);
            return false;
        }
    }
    return true;
}

void StreamSession::queue_v7() {
    const auto frames = v7_->unsent();
    raw_.insert(raw_.end(), frames.begin(), frames.end());
    v7_->written(frames.size());
}

// Takes a frame only when the previous one is written: urgent frames overtake those in the outbox, not those behind it.
void StreamSession::write_v7() {
    Outbox& outbox = channel_->outbox;
    if (is_open()) queue_v7();
    while (is_open()) {
        if (!write_raw_first()) {
            if (is_open()) outbox.set_congested();
            return;
        }
        if (outbox.empty()) break;
        const TimePoint now = context_.host.now();
        const std::size_t budget = pacing_.budget(outbox, now);
        std::span<const std::uint8_t> first;
        if (budget == 0 || outbox.gather({&first, 1}, now, budget) == 0) break;
        if (outbox.zeros() > 0) {
            raw_.insert(raw_.end(), first.begin(), first.end());
            outbox.sent(first.size());
        } else {
            v7_->take(outbox, ano::FrameView{first}, now);
            queue_v7();
        }
        if (pacing_.is_on()) pacing_.correct(held_by_driver(), now);
    }
    if (is_open() && holds_bytes()) write_held();
}

// False: not everything is written, or the connection is lost.
bool StreamSession::write_held() {
    const ssize_t n = write_some({});
    if (n < 0 && errno != EAGAIN && errno != EINTR) {
        failed(errno);
        return false;
    }
    if (!holds_bytes()) return true;
    channel_->outbox.set_congested();
    write_later();
    return false;
}

void StreamSession::write() {
    if (is_opening_ || (holds_bytes() && !write_held()) || (!raw_.empty() && !write_raw_first())) return;
    if (v7_) return write_v7();
    std::array<std::span<const std::uint8_t>, frames_per_write> frames;
    std::array<iovec, frames_per_write> pieces;
    Outbox& outbox = channel_->outbox;
    while (is_open() && !outbox.empty()) {
        const TimePoint now = context_.host.now();
        const std::size_t budget = pacing_.budget(outbox, now);
        if (budget == 0) break;
        const std::size_t count = outbox.gather(frames, now, budget);
        for (std::size_t i = 0; i < count; ++i) pieces[i] = {const_cast<std::uint8_t*>(frames[i].data()), frames[i].size()};
        if (count == 0) break;
        const ssize_t n = write_some(std::span{pieces}.first(count));
        if (n > 0) {
            if (tap_) [[unlikely]]
                pass_to_tap(std::span{frames}.first(count), static_cast<std::size_t>(n));
            outbox.sent(static_cast<std::size_t>(n));
            const TimePoint written = pacing_.pauses() ? context_.host.now() : now;
            pacing_.sent(static_cast<std::size_t>(n), written);
            if (pacing_.is_on()) pacing_.correct(held_by_driver(), written);
            if (!raw_.empty() && !write_raw_first()) return;    // waited for the end of a frame
        } else if (n == 0 || errno == EAGAIN) {
            outbox.set_congested();
            write_later();
            return;
        } else if (errno != EINTR) {
            return failed(errno);
        }
    }
    if (is_open() && holds_bytes()) write_held();
}

}    // namespace anogate
