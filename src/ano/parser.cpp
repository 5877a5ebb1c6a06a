#include <ano/parser.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>

namespace ano {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t read_room = 4096;
constexpr std::size_t sums_ahead = 1024;    // bytes summed beyond the needed ones: the next candidate will need them
constexpr std::size_t sums_slack = 64;      // a candidate this close after a refused one is likely to be refused too
constexpr Duration datagram_patience = 100ms;
constexpr Duration overdue_unknown_rate = 1s;    // plus the time of a longer frame on a line of 115200 baud
constexpr std::uint32_t assumed_rate = 11'520;
constexpr Duration overdue_grace = 200ms;

// A frame of the previous version: 0xAA D_ADDR ID LEN(u8) DATA SC AC, the same checks.
constexpr std::uint8_t v7_head = 0xAA;
constexpr unsigned v7_header_size = 4;
constexpr std::size_t v7_bytes_per_commit = 64;

constexpr std::size_t block = 64;
constexpr std::size_t length_of_heads = head << 8 | head;    // LEN if its two bytes are HEADs
constexpr int worth_a_block = 16;    // from this number of candidates with one LEN on, refusing them together is cheaper than one
                                     // by one
constexpr std::uint64_t ones = 0x0101010101010101;

inline std::uint64_t load_word(const std::uint8_t* bytes) noexcept {
    std::uint64_t word;
    std::memcpy(&word, bytes, sizeof word);
    return std::endian::native == std::endian::big ? __builtin_bswap64(word) : word;
}

// A bit for each zero byte of a block, whose words are difference(0), difference(8)...
template <class Difference>
inline std::uint64_t zeros_among(Difference difference) noexcept {
    constexpr std::uint64_t low = 0x7F * ones;
    std::uint64_t zeros = 0;
    for (std::size_t i = 0; i < block; i += 8) {
        const std::uint64_t word = difference(i);
        const std::uint64_t zero = ~(((word & low) + low) | word | low) >> 7;    // 1 in each byte that was 0
        zeros |= (zero * 0x0102040810204080 >> 56) << i;
    }
    return zeros;
}

inline std::uint64_t heads_among(const std::uint8_t* bytes) noexcept {
    return zeros_among([=](std::size_t i) { return load_word(bytes + i) ^ ones * head; });
}

inline std::uint64_t equal_among(const std::uint8_t* a, const std::uint8_t* b) noexcept {
    return zeros_among([=](std::size_t i) { return load_word(a + i) ^ load_word(b + i); });
}

inline std::size_t find_head(const std::uint8_t* bytes, std::size_t at, std::size_t end) noexcept {
    const void* found = at < end ? std::memchr(bytes + at, head, end - at) : nullptr;
    return found ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes) : end;
}

}    // namespace

// Twice the largest frame: a move to the beginning never moves more bytes than have arrived since the last move.
FrameParser::FrameParser(Options options)
    : options_{options},
      max_image_{std::min(max_image_data_at(options.max_data), max_len)},
      capacity_{2 * (overhead + max_image_) + read_room},
      usual_capacity_{2 * (overhead + std::min(options.max_data, max_len)) + read_room},
      buffer_{capacity_ + block},    // the search for HEADs reads complete blocks
      sums_{capacity_},
      pairs_{options.max_data} {
    options_.max_data = std::min(options.max_data, max_len);
}

std::span<std::uint8_t> FrameParser::prepare() noexcept {
    if (pos_ == end_) {
        pairs_.move_front(pos_);
        pos_ = end_ = barrier_ = sums_until_ = 0;
        sums_.begin(0);
    } else if (pos_ >= end_ - pos_ && usual_capacity_ < end_ + read_room) {
        std::memmove(buffer_.get(), buffer_.get() + pos_, end_ - pos_);
        sums_.move_front(pos_);
        pairs_.move_front(pos_);
        sums_until_ -= std::min(sums_until_, pos_);
        barrier_ -= std::min(barrier_, pos_);
        end_ -= pos_;
        pos_ = 0;
    }
    return {buffer_.get() + end_, std::max(usual_capacity_, std::min(end_ + read_room, capacity_)) - end_};
}

void FrameParser::commit(std::size_t n, TimePoint now) noexcept {
    assert(n <= capacity_ - end_);
    if (n == 0) return;
    end_ += n;
    std::memset(buffer_.get() + end_, 0, block);    // read together with the last bytes, so it must be initialised
    counters_.bytes_in += n;
    last_arrival_ = now;
    none_behind_ = none_at_end_ = false;
    v7_budget_ = std::min(v7_budget_ + std::min(n, v7_bytes_per_commit), capacity_);
}

std::optional<FrameView> FrameParser::next() noexcept {
    if (behind_frame_) drop_padding();
    if (pos_ == end_) return std::nullopt;
    const std::uint8_t* const bytes = buffer_.get();
    std::size_t at = bytes[pos_] == head ? pos_ : next_candidate(pos_);
    Verdict verdict = Verdict::incomplete;
    while (at < end_) {
        const bool no_rest = at < barrier_;
        verdict = judge(at, no_rest ? barrier_ : end_);
        if (verdict == Verdict::good || (verdict == Verdict::incomplete && !no_rest && !yields(at))) break;
        if (verdict == Verdict::too_long) note_long_image(at);
        ++(verdict == Verdict::bad        ? counters_.bad_check
           : verdict == Verdict::too_long ? counters_.bad_length
                                          : counters_.expired);
        at = next_candidate(at + 1);
    }
    if (at > pos_) {
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
    behind_frame_ = options_.zero_padding;
    v7_ = {};
    heard_.note(frame);
    pairs_.earn(frame.bytes().size());
    ++counters_.frames_in;
    return frame;
}

void FrameParser::drop_padding() noexcept {
    for (; pos_ < end_ && buffer_[pos_] == 0; ++pos_) --counters_.bytes_in;
    behind_frame_ = false;
}

bool FrameParser::begins_with_frame(std::span<const std::uint8_t> datagram) const noexcept {
    if (datagram.size() < overhead) return false;
    const auto frame = frame_at(datagram, max_data_of(datagram[3], options_.max_data));
    return frame && (frame->data().size() <= options_.max_data || is_plausible_image(datagram.data()));
}

void FrameParser::begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept {
    if (waiting() == 0) return;
    const Duration patience = options_.frame_gap > Duration{} ? options_.frame_gap : datagram_patience;
    if (now - last_arrival_ >= patience || begins_with_frame(datagram)) finish();
}

bool FrameParser::expire(TimePoint now) noexcept {
    if (!candidate_waits_) return false;
    const bool overdue = now >= overdue_at(pos_, candidate_since_);
    const bool quiet = now - last_arrival_ >= this->quiet();
    std::size_t good = 0;
    if (quiet && !none_behind_) {
        good = find_good_frame_behind(pos_);
        none_behind_ = good == 0;
    } else if (may_be_between_frames() && now >= next_look_between_frames()) {
        good = find_good_frames_to_the_end(pos_);
        none_at_end_ = good == 0;
        looked_at_ = now;
    }
    if (good != 0) {
        barrier_ = good;
        return true;
    }
    // While bytes still arrive, a candidate after this one may be an incomplete valid frame: only this one is given up.
    if (overdue) barrier_ = quiet ? first_not_overdue(now) : pos_ + 1;
    return overdue;
}

std::optional<TimePoint> FrameParser::deadline() const noexcept {
    if (!candidate_waits_) return std::nullopt;
    const TimePoint overdue = overdue_at(pos_, candidate_since_);
    if (may_be_between_frames()) return std::min(overdue, next_look_between_frames());
    return none_behind_ ? overdue : std::min(overdue, last_arrival_ + quiet());
}

// The next HEAD from `from` on, or end_. Candidates that are refused by their LEN or by the existing sums are skipped and counted
// here, since crafted input may have one at every byte.
std::size_t FrameParser::next_candidate(std::size_t from) noexcept {
    const std::uint8_t* const bytes = buffer_.get();
    const std::uint8_t* const sums = sums_.sums();
    const std::uint8_t* const gaps = sums_.gaps();
    const std::size_t max_data = options_.max_data;
    const std::size_t whole = end_ - std::min(end_, header_size - 1);    // no complete header begins here or later
    const std::size_t sums_end = std::min(sums_.end(), end_ - 1);        // SC must be before this position
    const std::size_t last = sums_end - std::min(sums_end, header_size);
    const std::uint8_t* const gaps_behind = gaps + std::min(sums_end, header_size);
    std::uint64_t passed = 0;    // counted per block, so that the common case costs nothing per candidate
    std::uint64_t too_long = 0;
    const auto stop_at = [&](std::size_t at) {
        counters_.bad_check += passed - too_long;
        counters_.bad_length += too_long;
        return at;
    };
    while (from < whole) {
        std::uint64_t heads = heads_among(bytes + from);
        if (whole - from < block) heads &= (std::uint64_t{1} << (whole - from)) - 1;
        if (heads == 0) {
            from = find_head(bytes, std::min(from + block, whole), end_);
            continue;
        }
        // Candidates whose LEN consists of two HEADs: the majority in dense HEADs.
        std::uint64_t refused = heads & heads >> 4 & heads >> 5;
        if (refused != 0) [[unlikely]]
            refused = refused_together(refused, from, sums_end);
        heads &= ~refused;
        const std::uint64_t looked_at = heads;
        for (; heads != 0; heads &= heads - 1) {
            const std::size_t at = from + static_cast<unsigned>(std::countr_zero(heads));
            const std::size_t length = data_length(bytes + at);
            if (length > max_data && !may_be_image(at, length)) {
                ++too_long;
                if (bytes[at + 3] == image_id) [[unlikely]]
                    note_long_image(at);
            } else if (at + length >= last ||
                       (sums[at] == gaps_behind[at + length] && !add_is_wrong(at, at + header_size + length))) [[unlikely]] {
                const std::uint64_t before = (std::uint64_t{1} << (at - from)) - 1;
                if (refused != 0) count_refused(refused & before);
                passed += static_cast<unsigned>(std::popcount(looked_at & before));
                return stop_at(at);
            }
        }
        passed += static_cast<unsigned>(std::popcount(looked_at));
        if (refused != 0) count_refused(refused);
        from = std::min(from + block, whole);
    }
    return stop_at(find_head(bytes, from, end_));
}

// The next three functions are not inlined, because that would slow down the loop above. This one returns the refused ones of
// `candidates`, which are in the block at `from` and have a LEN of two HEADs. It returns 0 if checking them one by one is
// cheaper, or if the sums end too early.
[[gnu::noinline]] std::uint64_t FrameParser::refused_together(std::uint64_t candidates, std::size_t from,
                                                              std::size_t sums_end) const noexcept {
    if (std::popcount(candidates) < worth_a_block) return 0;
    if (length_of_heads > options_.max_data) return candidates;    // and above max_image_, unless that is max_data
    const std::size_t to = from + header_size + length_of_heads;
    if (to + block > sums_end) return 0;
    return candidates & ~equal_among(sums_.sums() + from, sums_.gaps() + to);
}

[[gnu::noinline]] void FrameParser::count_refused(std::uint64_t heads) noexcept {
    (length_of_heads > options_.max_data ? counters_.bad_length
                                         : counters_.bad_check) += static_cast<unsigned>(std::popcount(heads));
}

[[gnu::noinline]] void FrameParser::note_long_image(std::size_t at) noexcept {
    const std::uint8_t* const begin = buffer_.get() + at;
    if (begin[3] != image_id || data_length(begin) <= max_image_) return;
    if (end_ - at >= image_head_size) count_long_image(begin);
    else long_image_at_ = counters_.skipped_bytes + (at - pos_);
}

void FrameParser::check_long_image() noexcept {
    std::array<std::uint8_t, image_head_size> begin;
    for (std::size_t i = 0; i < begin.size(); ++i)
        begin[i] = skipped_[static_cast<std::size_t>((*long_image_at_ + i) % kept_skipped)];
    const bool is_kept = counters_.skipped_bytes - *long_image_at_ <= kept_skipped;
    if (is_kept) count_long_image(begin.data());
    long_image_at_.reset();
}

void FrameParser::count_long_image(const std::uint8_t* begin) noexcept {
    if (!is_plausible_image(begin)) return;
    ++counters_.long_images;
    longest_image_ = std::max(longest_image_, data_length(begin));
}

// Called if the first check is right, which is rare.
[[gnu::noinline]] bool FrameParser::add_is_wrong(std::size_t at, std::size_t to) const noexcept {
    return sums_.add(at, to) != buffer_[to + 1];
}

FrameParser::Verdict FrameParser::judge(std::size_t at, std::size_t limit) noexcept {
    const std::size_t there = limit - at;
    if (there < header_size) return Verdict::incomplete;
    const std::size_t length = data_length(buffer_.get() + at);
    if (length > options_.max_data) {
        if (!may_be_image(at, length)) return Verdict::too_long;
        if (there < image_head_size) return Verdict::incomplete;
        if (!is_plausible_image(buffer_.get() + at)) return Verdict::too_long;
    }
    if (there < overhead + length) return Verdict::incomplete;
    return checks_hold(at, header_size + length) ? Verdict::good : Verdict::bad;
}

bool FrameParser::checks_hold(std::size_t at, std::size_t length) noexcept {
    const std::uint8_t* bytes = buffer_.get() + at;
    const std::size_t to = at + length;
    if (at >= sums_until_) {
        if (checks_of({bytes, length}) == Checks{bytes[length], bytes[length + 1]}) return true;
        sums_until_ = to + sums_slack;
        return false;
    }
    if (at > sums_.end()) sums_.begin(at);
    if (to >= sums_.end()) sums_.extend({buffer_.get(), end_}, to + sums_ahead);
    if (sums_.sum_holds(at, to) && !add_is_wrong(at, to)) return true;
    sums_until_ = std::max(sums_until_, to + sums_slack);
    return false;
}

// Whether an incomplete candidate is refused before its rest arrives: it is not credible by the received frames, and two
// consecutive valid frames follow its first byte. In a flood of headers it is not refused, because the search would cost more
// than the frames it finds are worth.
[[gnu::noinline]] bool FrameParser::yields(std::size_t at) noexcept {
    if (end_ - at <= overhead || counters_.frames_in == 0 || !pairs_.can_look()) return false;
    if (heard_.makes_credible(buffer_.get() + at)) return false;
    sum_up_from(at);
    const std::size_t to = std::min(end_, at + overhead + options_.max_data);    // only the beginning of an image is searched
    return pairs_.stand_behind(at, {buffer_.get(), to}, sums_, heard_);
}

// Sums all bytes after a waiting candidate, since any of them may be needed again.
void FrameParser::sum_up_from(std::size_t at) noexcept {
    if (at > sums_.end()) sums_.begin(at);
    sums_.extend({buffer_.get(), end_}, end_);
    sums_until_ = end_;
}

// 0: there is no valid frame.
std::size_t FrameParser::find_good_frame_behind(std::size_t at) noexcept {
    sum_up_from(at);
    while ((at = find_head(buffer_.get(), at + 1, end_)) < end_)
        if (judge(at, end_) == Verdict::good) return at;
    return 0;
}

// Where valid frames behind `at` begin, of which the last one ends with the last byte received: then this is the pause between
// frames, and not one inside the candidate at `at`. 0: there are none.
std::size_t FrameParser::find_good_frames_to_the_end(std::size_t at) noexcept {
    const std::size_t first = find_good_frame_behind(at);
    std::size_t next = first;
    while (next != 0 && next + overhead + data_length(buffer_.get() + next) < end_)
        next = find_good_frame_behind(next + overhead + data_length(buffer_.get() + next) - 1);
    return next != 0 ? first : 0;
}

// The next candidate after the waiting one that is not overdue. Of its arrival, only the latest possible time is known:
// last_arrival_.
std::size_t FrameParser::first_not_overdue(TimePoint now) const noexcept {
    std::size_t at = pos_;
    do at = find_head(buffer_.get(), at + 1, end_);
    while (at < end_ && now >= overdue_at(at, last_arrival_));
    return at;
}

void FrameParser::skip_to(std::size_t at) noexcept {
    keep_skipped({buffer_.get() + pos_, at - pos_});
    counters_.skipped_bytes += at - pos_;
    if (long_image_at_ && counters_.skipped_bytes >= *long_image_at_ + image_head_size) [[unlikely]]
        check_long_image();
    frames_at_skip_ = counters_.frames_in;
    for (; pos_ < at && v7_budget_ > 0; ++pos_, --v7_budget_)
        if (v7_.take(buffer_[pos_])) ++counters_.v7_frames;
    if (pos_ < at) v7_ = {};
    pos_ = at;
}

void FrameParser::keep_skipped(std::span<const std::uint8_t> bytes) noexcept {
    std::uint64_t number = counters_.skipped_bytes + bytes.size();
    bytes = bytes.last(std::min(bytes.size(), kept_skipped));
    number -= bytes.size();
    while (!bytes.empty()) {
        const auto place = static_cast<std::size_t>(number % kept_skipped);
        const std::size_t n = std::min(bytes.size(), kept_skipped - place);
        std::memcpy(skipped_.get() + place, bytes.data(), n);
        bytes = bytes.subspan(n);
        number += n;
    }
}

std::size_t FrameParser::copy_skipped(std::span<std::uint8_t> into) const noexcept {
    const std::uint64_t end = counters_.skipped_bytes;
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>({end, kept_skipped, into.size()}));
    for (std::size_t i = 0; i < n; ++i) into[i] = skipped_[static_cast<std::size_t>((end - n + i) % kept_skipped)];
    return n;
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

// At the end of a pause, or even without one if the candidate takes longer than the line needs.
TimePoint FrameParser::next_look_between_frames() const noexcept {
    return std::min(last_arrival_, std::max(overdue_without_pauses_at(pos_, candidate_since_), looked_at_)) + options_.quiet;
}

TimePoint FrameParser::overdue_without_pauses_at(std::size_t candidate, TimePoint since) const noexcept {
    const std::size_t there = end_ - candidate;
    const std::size_t length = there < header_size ? 0 : data_length(buffer_.get() + candidate);
    const bool is_unchecked = length > options_.max_data && there < image_head_size;    // it may be an image
    const std::size_t wanted = overhead + (is_unchecked ? options_.max_data : length);
    const bool is_usual = wanted <= overhead + usual_max_data;
    if (options_.line_rate == 0 && is_usual) return since + overdue_unknown_rate;
    const Duration grace = options_.line_rate != 0 ? overdue_grace : overdue_unknown_rate;
    return since + grace + Duration{std::chrono::seconds{wanted}} / (options_.line_rate != 0 ? options_.line_rate : assumed_rate);
}

// If pauses are normal, a frame is incomplete but not overdue as long as its bytes arrive.
TimePoint FrameParser::overdue_at(std::size_t candidate, TimePoint since) const noexcept {
    const TimePoint overdue = overdue_without_pauses_at(candidate, since);
    return options_.frame_gap > Duration{} ? std::max(overdue, last_arrival_ + options_.frame_gap) : overdue;
}

}    // namespace ano
