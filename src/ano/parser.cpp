#include <ano/parser.hpp>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace ano {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t read_room = 4096;
constexpr Duration datagram_patience = 100ms;
constexpr Duration overdue_unknown_rate = 1s;
constexpr Duration overdue_grace = 200ms;

// A frame of the previous version: 0xAA D_ADDR ID LEN(u8) DATA SC AC, the same checks.
constexpr std::uint8_t v7_head = 0xAA;
constexpr std::size_t v7_header_size = 4;
constexpr int v7_looks_per_commit = 4;

}  // namespace

// Twice the largest frame: what is moved to the front is never more than what came in since the last move.
FrameParser::FrameParser(Options options)
    : options_{options},
      capacity_{2 * (overhead + options.max_data) + read_room},
      buffer_{new std::uint8_t[capacity_]},
      sums_{new Checks[capacity_ + 1]} {
    assert(options.max_data <= largest_data);
}

std::span<std::uint8_t> FrameParser::prepare() noexcept {
    if (pos_ == end_) {
        pos_ = end_ = barrier_ = sums_until_ = 0;
    } else if (pos_ > 0 && capacity_ - end_ < read_room) {
        std::memmove(buffer_.get(), buffer_.get() + pos_, end_ - pos_);
        barrier_ -= std::min(barrier_, pos_);
        end_ -= pos_;
        pos_ = sums_until_ = 0;
    }
    return {buffer_.get() + end_, capacity_ - end_};
}

void FrameParser::commit(std::size_t n, TimePoint now) noexcept {
    assert(n <= capacity_ - end_);
    if (n == 0) return;
    end_ += n;
    counters_.bytes_in += n;
    last_arrival_ = now;
    searched_behind_ = false;
    v7_budget_ = v7_looks_per_commit;
}

std::optional<FrameView> FrameParser::next() noexcept {
    while (pos_ < end_) {
        const std::uint8_t* at = buffer_.get() + pos_;
        if (*at != head) {
            const void* found = std::memchr(at, head, end_ - pos_);
            skip(found ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - at) : end_ - pos_);
            continue;
        }
        const bool no_rest = pos_ < barrier_;
        switch (judge(pos_, no_rest ? barrier_ : end_)) {
        case Verdict::good: {
            const FrameView frame{{at, overhead + data_length(at)}};
            pos_ += frame.bytes().size();
            ++counters_.frames_in;
            candidate_waits_ = false;
            return frame;
        }
        case Verdict::too_long: ++counters_.bad_length; break;
        case Verdict::bad: ++counters_.bad_check; break;
        case Verdict::incomplete:
            if (!no_rest) {
                wait_for_rest();
                return std::nullopt;
            }
            ++counters_.expired;
            break;
        }
        skip(1);
    }
    candidate_waits_ = false;
    return std::nullopt;
}

void FrameParser::begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept {
    if (waiting() == 0) return;
    if (now - last_arrival_ >= datagram_patience || frame_at(datagram, options_.max_data)) finish();
}

bool FrameParser::expire(TimePoint now) noexcept {
    if (!candidate_waits_) return false;
    const bool overdue = now >= overdue_at();
    const bool quiet = now - last_arrival_ >= options_.quiet && !searched_behind_;
    if (!overdue && !quiet) return false;
    searched_behind_ = true;
    if (const std::size_t good = find_good_frame_behind(pos_)) {
        barrier_ = good;
    } else if (overdue) {
        barrier_ = pos_ + 1;
    } else {
        return false;
    }
    return true;
}

std::optional<TimePoint> FrameParser::deadline() const noexcept {
    if (!candidate_waits_) return std::nullopt;
    return searched_behind_ ? overdue_at() : std::min(overdue_at(), last_arrival_ + options_.quiet);
}

FrameParser::Verdict FrameParser::judge(std::size_t at, std::size_t limit) noexcept {
    const std::size_t there = limit - at;
    if (there < header_size) return Verdict::incomplete;
    const std::size_t length = data_length(buffer_.get() + at);
    if (length > options_.max_data) return Verdict::too_long;
    if (there < overhead + length) return Verdict::incomplete;
    return checks_hold(at, header_size + length) ? Verdict::good : Verdict::bad;
}

bool FrameParser::checks_hold(std::size_t at, std::size_t length) noexcept {
    const std::uint8_t* bytes = buffer_.get() + at;
    const Checks told{bytes[length], bytes[length + 1]};
    if (at >= sums_until_) {
        if (checks_of({bytes, length}) == told) return true;
        sums_end_ = at;
        sums_[at] = {};
        sums_until_ = at + length;
        return false;
    }
    if (at + length > sums_until_) sums_until_ = at + length;
    extend_sums(at + length);
    // With S the sum of all bytes up to a place and T the sum of all S: sum = S' - S, add = T' - T - length * S.
    const Checks before = sums_[at];
    const Checks behind = sums_[at + length];
    return static_cast<std::uint8_t>(behind.sum - before.sum) == told.sum &&
           static_cast<std::uint8_t>(behind.add - before.add - length * before.sum) == told.add;
}

void FrameParser::extend_sums(std::size_t to) noexcept {
    Checks run = sums_[sums_end_];
    for (; sums_end_ < to; ++sums_end_) {
        run.sum = static_cast<std::uint8_t>(run.sum + buffer_[sums_end_]);
        run.add = static_cast<std::uint8_t>(run.add + run.sum);
        sums_[sums_end_ + 1] = run;
    }
}

// 0: there is none. Every place behind the waiting candidate is judged in constant time, from sums that begin at it.
std::size_t FrameParser::find_good_frame_behind(std::size_t at) noexcept {
    if (at >= sums_until_) {
        sums_end_ = at;
        sums_[at] = {};
    }
    sums_until_ = end_;
    while (++at < end_) {
        const void* found = std::memchr(buffer_.get() + at, head, end_ - at);
        if (!found) break;
        at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - buffer_.get());
        if (judge(at, end_) == Verdict::good) return at;
    }
    return 0;
}

void FrameParser::skip(std::size_t n) noexcept {
    counters_.skipped_bytes += n;
    if (v7_budget_ > 0) {
        if (const void* found = std::memchr(buffer_.get() + pos_, v7_head, n))
            look_for_v7(static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - buffer_.get()));
    }
    pos_ += n;
    candidate_waits_ = false;
}

void FrameParser::look_for_v7(std::size_t at) noexcept {
    --v7_budget_;
    const std::size_t there = end_ - at;
    if (there < v7_header_size + 2) return;
    const std::uint8_t* bytes = buffer_.get() + at;
    const std::size_t length = v7_header_size + bytes[3];
    if (there < length + 2) return;
    if (checks_of({bytes, length}) == Checks{bytes[length], bytes[length + 1]}) ++counters_.v7_frames;
}

void FrameParser::wait_for_rest() noexcept {
    if (candidate_waits_) return;
    candidate_waits_ = true;
    searched_behind_ = false;
    candidate_since_ = last_arrival_;
}

std::size_t FrameParser::wanted() const noexcept {
    return end_ - pos_ < header_size ? overhead : overhead + data_length(buffer_.get() + pos_);
}

TimePoint FrameParser::overdue_at() const noexcept {
    if (options_.line_rate == 0) return candidate_since_ + overdue_unknown_rate;
    return candidate_since_ + overdue_grace + Duration{std::chrono::seconds{wanted()}} / options_.line_rate;
}

}  // namespace ano
