#include <ano/v7.hpp>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace ano::v7 {
namespace {

constexpr std::size_t v7_read_room = 4096;
// The rest of a frame is moved to the beginning only when more bytes than that are before it, so a byte is moved at most once.
constexpr std::size_t v7_capacity = 2 * max_frame_size + v7_read_room;
constexpr Duration v7_datagram_patience = std::chrono::milliseconds{100};

}    // namespace

FrameParser::FrameParser(Options options) : options_{options}, buffer_{v7_capacity}, sums_{v7_capacity} {
    options_.max_data = std::min(options_.max_data, max_len);
    sums_.begin(0);
}

std::span<std::uint8_t> FrameParser::prepare() noexcept {
    if (pos_ == end_) {
        pos_ = end_ = barrier_ = 0;
        sums_.begin(0);
    } else if (v7_capacity < end_ + v7_read_room) {
        std::memmove(buffer_.get(), buffer_.get() + pos_, end_ - pos_);
        sums_.move_front(pos_);
        barrier_ -= std::min(barrier_, pos_);
        end_ -= pos_;
        pos_ = 0;
    }
    return {buffer_.get() + end_, v7_capacity - end_};
}

void FrameParser::commit(std::size_t n, TimePoint now) noexcept {
    assert(n <= v7_capacity - end_);
    if (n == 0) return;
    end_ += n;
    sums_.extend({buffer_.get(), end_}, end_);
    counters_.bytes_in += n;
    last_arrival_ = now;
    none_behind_ = none_at_end_ = false;
}

std::optional<FrameView> FrameParser::next() noexcept {
    while (pos_ < end_) {
        const std::size_t at = find_head(pos_);
        counters_.skipped_bytes += at - pos_;
        pos_ = at;
        if (at == end_) break;
        const bool no_rest = at < barrier_;
        const Verdict verdict = judge(at, no_rest ? barrier_ : end_);
        if (verdict == Verdict::good) {
            const FrameView frame{{buffer_.get() + at, overhead + buffer_[at + 3]}};
            pos_ = at + frame.bytes().size();
            ++counters_.frames_in;
            return frame;
        }
        if (verdict == Verdict::incomplete && !no_rest) return std::nullopt;
        ++(verdict == Verdict::bad        ? counters_.bad_check
           : verdict == Verdict::too_long ? counters_.bad_length
                                          : counters_.expired);
        ++counters_.skipped_bytes;
        ++pos_;
    }
    return std::nullopt;
}

void FrameParser::begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept {
    if (waiting() == 0) return;
    if (now - last_arrival_ >= std::max(v7_datagram_patience, longest_pause()) || frame_at(datagram, options_.max_data)) finish();
}

bool FrameParser::expire(TimePoint now) noexcept {
    if (waiting() == 0) return false;
    const Duration silence = now - last_arrival_;
    const bool may_go_on = silence < longest_pause();
    bool& none = may_go_on ? none_at_end_ : none_behind_;
    if (silence >= options_.quiet && !none) {
        const std::size_t good = may_go_on ? find_good_frames_to_the_end(pos_) : find_good_frame_behind(pos_);
        if (good != end_) {
            barrier_ = good;
            return true;
        }
        none = true;
    }
    if (silence < std::max(patience, longest_pause())) return false;
    barrier_ = end_;
    return true;
}

std::optional<TimePoint> FrameParser::deadline() const noexcept {
    if (waiting() == 0) return std::nullopt;
    if (none_behind_) return last_arrival_ + std::max(patience, longest_pause());
    return last_arrival_ + (none_at_end_ ? longest_pause() : options_.quiet);
}

FrameParser::Verdict FrameParser::judge(std::size_t at, std::size_t limit) const noexcept {
    const std::size_t there = limit - at;
    if (there < header_size) return Verdict::incomplete;
    const std::size_t length = buffer_[at + 3];
    if (length > options_.max_data) return Verdict::too_long;
    if (there < overhead + length) return Verdict::incomplete;
    const std::size_t sum_at = at + header_size + length;
    const bool holds = sums_.sum_holds(at, sum_at) && sums_.add(at, sum_at) == buffer_[sum_at + 1];
    return holds ? Verdict::good : Verdict::bad;
}

// The next HEAD, or end_.
std::size_t FrameParser::find_head(std::size_t from) const noexcept {
    const void* found = from < end_ ? std::memchr(buffer_.get() + from, head, end_ - from) : nullptr;
    return found ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - buffer_.get()) : end_;
}

// end_: there is no valid frame.
std::size_t FrameParser::find_good_frame_behind(std::size_t at) const noexcept {
    do at = find_head(at + 1);
    while (at < end_ && judge(at, end_) != Verdict::good);
    return at;
}

// Where valid frames behind `at` begin, of which the last one ends with the last byte received; end_: there are none.
std::size_t FrameParser::find_good_frames_to_the_end(std::size_t at) const noexcept {
    const std::size_t first = find_good_frame_behind(at);
    std::size_t next = first;
    while (next < end_ && next + overhead + buffer_[next + 3] < end_)
        next = find_good_frame_behind(next + overhead + buffer_[next + 3] - 1);
    return next < end_ ? first : end_;
}

}    // namespace ano::v7
