#include <ano/parser.hpp>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

namespace ano {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t read_room = 4096;
constexpr std::size_t sums_ahead = 128;
constexpr Duration datagram_patience = 100ms;
constexpr Duration overdue_unknown_rate = 1s;
constexpr Duration overdue_grace = 200ms;

// A frame of the previous version: 0xAA D_ADDR ID LEN(u8) DATA SC AC, the same checks.
constexpr std::uint8_t v7_head = 0xAA;
constexpr unsigned v7_header_size = 4;
constexpr std::size_t v7_bytes_per_commit = 256;

// Goes from HEAD to HEAD in [at, end). Headers may stand close together, so they are taken from a word of 8 bytes, the
// top bit of each that is a HEAD, without waiting for one to find the next; where there is none, memchr is faster.
class Heads {
public:
    Heads(const std::uint8_t* bytes, std::size_t at, std::size_t end) noexcept
        : bytes_{bytes}, end_{end}, behind_{at} {}

    /// `end` when there is no further one.
    std::size_t next() noexcept {
        if (found_ == 0 && !load()) return end_;
        const std::size_t at = word_ + static_cast<std::size_t>(std::countr_zero(found_)) / 8;
        found_ &= found_ - 1;
        return at;
    }

private:
    bool load() noexcept {
        if (end_ - behind_ >= 8) take(8);
        if (found_ != 0) return true;
        if (behind_ == end_) return false;
        const void* head_at = std::memchr(bytes_ + behind_, head, end_ - behind_);
        if (head_at == nullptr) return false;
        behind_ = static_cast<std::size_t>(static_cast<const std::uint8_t*>(head_at) - bytes_);
        take(std::min<std::size_t>(8, end_ - behind_));
        return true;
    }

    void take(std::size_t n) noexcept {
        constexpr std::uint64_t low_bits = 0x7F7F7F7F7F7F7F7F;
        std::uint64_t word = 0;
        std::memcpy(&word, bytes_ + behind_, n);
        if constexpr (std::endian::native == std::endian::big) word = __builtin_bswap64(word);
        word ^= 0x0101010101010101u * head;
        found_ = ~(((word & low_bits) + low_bits) | word | low_bits);
        word_ = behind_;
        behind_ += n;
    }

    const std::uint8_t* bytes_;
    std::size_t end_;
    std::size_t behind_;    // what was looked at ends here
    std::size_t word_ = 0;
    std::uint64_t found_ = 0;    // in the word that begins there
};

}    // namespace

// Twice the largest frame: what is moved to the front is never more than what came in since the last move.
FrameParser::FrameParser(Options options)
    : options_{options},
      capacity_{2 * (overhead + std::min(options.max_data, largest_data)) + read_room},
      buffer_{new std::uint8_t[capacity_]},
      sums_{new Checks[capacity_ + 1]} {}

std::span<std::uint8_t> FrameParser::prepare() noexcept {
    if (pos_ == end_) {
        pos_ = end_ = barrier_ = sums_until_ = sums_end_ = 0;
        begin_sums(0);
    } else if (pos_ > 0 && capacity_ - end_ < read_room) {
        std::memmove(buffer_.get(), buffer_.get() + pos_, end_ - pos_);
        if (sums_end_ > pos_) {
            std::memmove(sums_.get(), sums_.get() + pos_, (sums_end_ - pos_ + 1) * sizeof(Checks));
            sums_end_ -= pos_;
        } else {
            begin_sums(0);
        }
        sums_until_ -= std::min(sums_until_, pos_);
        barrier_ -= std::min(barrier_, pos_);
        end_ -= pos_;
        pos_ = 0;
    }
    return {buffer_.get() + end_, capacity_ - end_};
}

void FrameParser::commit(std::size_t n, TimePoint now) noexcept {
    assert(n <= capacity_ - end_);
    if (n == 0) return;
    end_ += n;
    counters_.bytes_in += n;
    last_arrival_ = now;
    none_behind_ = false;
    v7_budget_ = v7_bytes_per_commit;
}

std::optional<FrameView> FrameParser::next() noexcept {
    if (pos_ == end_) return std::nullopt;
    const std::uint8_t* const bytes = buffer_.get();
    Heads heads{bytes, pos_ + 1, end_};
    std::size_t at = bytes[pos_] == head ? pos_ : heads.next();
    Verdict verdict = Verdict::incomplete;
    std::uint64_t bad = 0;
    std::uint64_t too_long = 0;
    std::uint64_t expired = 0;
    for (; at < end_; at = heads.next()) {
        const bool no_rest = at < barrier_;
        verdict = judge(at, no_rest ? barrier_ : end_);
        if (verdict == Verdict::good || (verdict == Verdict::incomplete && !no_rest)) break;
        bad += verdict == Verdict::bad;
        too_long += verdict == Verdict::too_long;
        expired += verdict == Verdict::incomplete;
    }
    if (at > pos_) {
        counters_.bad_check += bad;
        counters_.bad_length += too_long;
        counters_.expired += expired;
        skip_to(at);
        candidate_waits_ = false;
    }
    if (at == end_) return std::nullopt;
    if (verdict == Verdict::incomplete) {
        if (!candidate_waits_) candidate_since_ = last_arrival_;
        candidate_waits_ = true;
        return std::nullopt;
    }
    candidate_waits_ = false;
    const FrameView frame{{bytes + at, overhead + data_length(bytes + at)}};
    pos_ = at + frame.bytes().size();
    v7_ = {};
    ++counters_.frames_in;
    return frame;
}

void FrameParser::begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept {
    if (waiting() == 0) return;
    if (now - last_arrival_ >= datagram_patience || frame_at(datagram, options_.max_data)) finish();
}

bool FrameParser::expire(TimePoint now) noexcept {
    if (!candidate_waits_) return false;
    const bool overdue = now >= overdue_at(pos_, candidate_since_);
    const bool quiet = now - last_arrival_ >= options_.quiet;
    if (quiet && !none_behind_) {
        if (const std::size_t good = find_good_frame_behind(pos_)) {
            barrier_ = good;
            return true;
        }
        none_behind_ = true;
    }
    // While bytes still come, what stands behind this candidate may be a frame on its way.
    if (overdue) barrier_ = quiet ? first_not_overdue(now) : pos_ + 1;
    return overdue;
}

std::optional<TimePoint> FrameParser::deadline() const noexcept {
    if (!candidate_waits_) return std::nullopt;
    const TimePoint overdue = overdue_at(pos_, candidate_since_);
    return none_behind_ ? overdue : std::min(overdue, last_arrival_ + options_.quiet);
}

inline FrameParser::Verdict FrameParser::judge(std::size_t at, std::size_t limit) noexcept {
    const std::size_t there = limit - at;
    if (there < header_size) return Verdict::incomplete;
    const std::size_t length = data_length(buffer_.get() + at);
    if (length > options_.max_data) return Verdict::too_long;
    if (there < overhead + length) return Verdict::incomplete;
    return checks_hold(at, header_size + length) ? Verdict::good : Verdict::bad;
}

inline bool FrameParser::checks_hold(std::size_t at, std::size_t length) noexcept {
    const std::uint8_t* bytes = buffer_.get() + at;
    const Checks told{bytes[length], bytes[length + 1]};
    if (at >= sums_until_) {
        if (checks_of({bytes, length}) == told) return true;
        sums_until_ = at + length;
        return false;
    }
    if (at > sums_end_) begin_sums(at);
    if (at + length > sums_end_) extend_sums(at + length);
    // With S the sum of all bytes up to a place and T the sum of all S: sum = S' - S, add = T' - T - length * S.
    const Checks before = sums_[at];
    const Checks behind = sums_[at + length];
    if (static_cast<std::uint8_t>(behind.sum - before.sum) == told.sum &&
        static_cast<std::uint8_t>(behind.add - before.add - length * before.sum) == told.add)
        return true;
    if (at + length > sums_until_) sums_until_ = at + length;
    return false;
}

void FrameParser::begin_sums(std::size_t at) noexcept {
    sums_end_ = at;
    sums_[at] = {};
}

// A little further than asked for, since the next candidate will ask for more.
void FrameParser::extend_sums(std::size_t to) noexcept {
    to = std::min(to + sums_ahead, end_);
    const std::uint8_t* bytes = buffer_.get();
    Checks* sums = sums_.get();
    unsigned sum = sums[sums_end_].sum;
    unsigned add = sums[sums_end_].add;
    for (std::size_t i = sums_end_; i < to; ++i) {
        sum += bytes[i];
        add += sum;
        sums[i + 1] = {static_cast<std::uint8_t>(sum), static_cast<std::uint8_t>(add)};
    }
    sums_end_ = to;
}

// 0: there is none. The sums are made for every byte from the waiting candidate on, since any may be asked for again.
std::size_t FrameParser::find_good_frame_behind(std::size_t at) noexcept {
    if (at > sums_end_) begin_sums(at);
    extend_sums(end_);
    sums_until_ = end_;
    Heads heads{buffer_.get(), at + 1, end_};
    while ((at = heads.next()) < end_)
        if (judge(at, end_) == Verdict::good) return at;
    return 0;
}

// Among what stands behind the waiting candidate, where there is no good frame. It came at last_arrival_ at the latest:
// no more than that is known of it.
std::size_t FrameParser::first_not_overdue(TimePoint now) const noexcept {
    Heads heads{buffer_.get(), pos_ + 1, end_};
    std::size_t at = heads.next();
    while (at < end_ && now >= overdue_at(at, last_arrival_)) at = heads.next();
    return at;
}

void FrameParser::skip_to(std::size_t at) noexcept {
    counters_.skipped_bytes += at - pos_;
    for (; pos_ < at && v7_budget_ > 0; ++pos_, --v7_budget_)
        if (v7_.take(buffer_[pos_])) ++counters_.v7_frames;
    if (pos_ < at) v7_ = {};
    pos_ = at;
}

bool FrameParser::V7Matcher::take(std::uint8_t byte) noexcept {
    if (place == 0) {
        if (byte != v7_head) return false;
        *this = {};
        length = v7_header_size;
    } else if (place == v7_header_size - 1) {
        length += byte;
    }
    if (place >= length) {
        const bool last = place > length;
        const bool holds = byte == (last ? add : sum);
        place = last || !holds ? 0 : place + 1;
        return last && holds;
    }
    ++place;
    sum = static_cast<std::uint8_t>(sum + byte);
    add = static_cast<std::uint8_t>(add + sum);
    return false;
}

TimePoint FrameParser::overdue_at(std::size_t candidate, TimePoint since) const noexcept {
    if (options_.line_rate == 0) return since + overdue_unknown_rate;
    const std::size_t wanted =
        end_ - candidate < header_size ? overhead : overhead + data_length(buffer_.get() + candidate);
    return since + overdue_grace + Duration{std::chrono::seconds{wanted}} / options_.line_rate;
}

}    // namespace ano
