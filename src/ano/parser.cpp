#include <ano/parser.hpp>

#include <algorithm>
#include <bit>
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
constexpr unsigned v7_header_size = 4;
constexpr std::size_t v7_bytes_per_commit = 128;

constexpr std::size_t block = 64;
constexpr std::uint64_t all_heads = ~std::uint64_t{0};

// A bit for each HEAD among the 64 bytes at `bytes`.
std::uint64_t heads_in_block(const std::uint8_t* bytes) noexcept {
    constexpr std::uint64_t ones = 0x0101010101010101;
    constexpr std::uint64_t low = 0x7F * ones;
    std::uint64_t heads = 0;
    for (std::size_t i = 0; i < block; i += 8) {
        std::uint64_t word;
        std::memcpy(&word, bytes + i, sizeof word);
        if constexpr (std::endian::native == std::endian::big) word = __builtin_bswap64(word);
        word ^= ones * head;
        const std::uint64_t zero = ~(((word & low) + low) | word | low) >> 7;    // 1 in each byte that was HEAD
        heads |= (zero * 0x0102040810204080 >> 56) << i;
    }
    return heads;
}

}  // namespace

// Twice the largest frame: what is moved to the front is never more than what came in since the last move.
FrameParser::FrameParser(Options options)
    : options_{options},
      capacity_{2 * (overhead + std::min(options.max_data, largest_data)) + read_room},
      buffer_{new std::uint8_t[capacity_ + header_size + block]},    // a block of HEADs may be looked at beyond the end
      sums_{capacity_} {}

std::span<std::uint8_t> FrameParser::prepare() noexcept {
    if (pos_ == end_) {
        pos_ = end_ = barrier_ = sums_until_ = 0;
    } else if (pos_ > 0 && capacity_ - end_ < read_room) {
        std::memmove(buffer_.get(), buffer_.get() + pos_, end_ - pos_);
        if (sums_until_ > pos_) sums_.move_front(pos_);
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
    if (behind_frame_) drop_padding();
    while (pos_ < end_) {
        if (pos_ < sums_until_) step_over_refused();
        if (buffer_[pos_] != head) {
            skip_to(next_head(pos_));
            continue;
        }
        const bool no_rest = pos_ < barrier_;
        switch (judge(pos_, no_rest ? barrier_ : end_)) {
        case Verdict::good: return take_frame();
        case Verdict::too_long: ++counters_.bad_length; break;
        case Verdict::bad: ++counters_.bad_check; break;
        case Verdict::incomplete:
            if (!no_rest) {
                if (!candidate_waits_) candidate_since_ = last_arrival_;
                candidate_waits_ = true;
                return std::nullopt;
            }
            ++counters_.expired;
            break;
        }
        skip_to(pos_ + 1);
    }
    return std::nullopt;
}

FrameView FrameParser::take_frame() noexcept {
    const std::uint8_t* at = buffer_.get() + pos_;
    const FrameView frame{{at, overhead + data_length(at)}};
    pos_ += frame.bytes().size();
    candidate_waits_ = false;
    behind_frame_ = options_.zero_padding;
    v7_ = {};
    ++counters_.frames_in;
    return frame;
}

void FrameParser::drop_padding() noexcept {
    for (; pos_ < end_ && buffer_[pos_] == 0; ++pos_) --counters_.bytes_in;
    behind_frame_ = false;
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
    if (at >= sums_until_) {
        if (checks_of({bytes, length}) == Checks{bytes[length], bytes[length + 1]}) return true;
        sums_.begin(at);
        sums_until_ = at + length;
        return false;
    }
    if (checks_hold_by_sums(at, length)) return true;
    sums_until_ = std::max(sums_until_, at + length);
    return false;
}

bool FrameParser::checks_hold_by_sums(std::size_t at, std::size_t length) noexcept {
    const std::size_t to = at + length;
    if (to >= sums_.end()) sums_.extend({buffer_.get(), end_}, to + 1);
    return sums_.sum_holds(at, to) && sums_.add(at, to) == buffer_[to + 1];
}

// Nothing but HEAD, from `begin` to behind the last of 64 LEN fields: 64 candidates of one length, judged side by side.
bool FrameParser::refuse_block_of_heads(std::size_t begin, std::size_t last_sum) noexcept {
    constexpr std::size_t length = head << 8 | head;
    if (heads_in_block(buffer_.get() + begin + header_size) != all_heads) return false;
    if (length > options_.max_data) {
        counters_.bad_length += block;
        return true;
    }
    const std::size_t to = begin + header_size + length;
    if (to + block > last_sum) return false;
    const std::uint8_t* const sums = sums_.sums() + begin;
    const std::uint8_t* const gaps = sums_.gaps() + to;
    unsigned equal = 0;
    for (std::size_t i = 0; i < block; ++i) equal |= sums[i] == gaps[i];
    if (equal != 0) return false;
    counters_.bad_check += block;
    return true;
}

// The same verdicts as in next(), in one tight loop: over whole candidates that are refused, to the first that is not, or
// to where the sums are no longer needed. By this, input that is made of headers is hardly dearer than good frames.
void FrameParser::step_over_refused() noexcept {
    const std::size_t limit = pos_ < barrier_ ? barrier_ : end_;
    if (limit < pos_ + overhead) return;
    sums_.extend({buffer_.get(), limit}, limit);
    const std::uint8_t* const bytes = buffer_.get();
    const std::uint8_t* const sums = sums_.sums();
    const std::uint8_t* const gaps = sums_.gaps();
    const std::size_t max_data = options_.max_data;
    const std::size_t stop = std::min(sums_until_, limit - overhead + 1);    // no whole frame begins there or behind
    const std::size_t last_sum = limit - 2;                                  // the last place where SC may stand
    std::size_t at = pos_;
    bool to_be_judged = false;
    for (std::size_t begin = at; begin < stop && !to_be_judged; begin += block) {
        std::uint64_t heads = heads_in_block(bytes + begin);
        if (stop - begin < block) heads &= (std::uint64_t{1} << (stop - begin)) - 1;
        if (heads == all_heads && refuse_block_of_heads(begin, last_sum)) {
            at = begin + block;
            continue;
        }
        std::uint64_t refused = heads;
        std::uint64_t too_long = 0;
        at = std::min(begin + block, stop);
        for (; heads != 0; heads &= heads - 1) {
            const std::size_t here = begin + static_cast<std::size_t>(std::countr_zero(heads));
            const std::size_t length = data_length(bytes + here);
            const std::size_t to = here + header_size + length;
            if (length > max_data) {
                ++too_long;
            } else if (to > last_sum || (sums[here] == gaps[to] && sums_.add(here, to) == bytes[to + 1])) {
                at = here;
                to_be_judged = true;
                refused ^= heads;
                break;
            }
        }
        counters_.bad_length += too_long;
        counters_.bad_check += static_cast<std::uint64_t>(std::popcount(refused)) - too_long;
    }
    if (at == pos_) return;
    sums_until_ = limit;    // what is there is summed already: no need to sum it again
    skip_to(at);
}

// 0: there is none. The sums are made for every byte from the waiting candidate on, since any may be asked for again.
std::size_t FrameParser::find_good_frame_behind(std::size_t at) noexcept {
    if (at >= sums_until_) sums_.begin(at);
    sums_.extend({buffer_.get(), end_}, end_);
    sums_until_ = end_;
    while ((at = next_head(at + 1)) < end_)
        if (judge(at, end_) == Verdict::good) return at;
    return 0;
}

// Among what stands behind the waiting candidate, where there is no good frame. It came at last_arrival_ at the latest:
// no more than that is known of it.
std::size_t FrameParser::first_not_overdue(TimePoint now) const noexcept {
    std::size_t at = next_head(pos_ + 1);
    while (at < end_ && now >= overdue_at(at, last_arrival_)) at = next_head(at + 1);
    return at;
}

std::size_t FrameParser::next_head(std::size_t from) const noexcept {
    const void* found = from < end_ ? std::memchr(buffer_.get() + from, head, end_ - from) : nullptr;
    return found ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - buffer_.get()) : end_;
}

void FrameParser::skip_to(std::size_t at) noexcept {
    counters_.skipped_bytes += at - pos_;
    for (; pos_ < at && v7_budget_ > 0; ++pos_, --v7_budget_)
        if (v7_.take(buffer_[pos_])) ++counters_.v7_frames;
    if (pos_ < at) v7_ = {};
    pos_ = at;
    candidate_waits_ = false;
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

}  // namespace ano
