#include <ano/frame_pairs.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

namespace ano {
namespace {

// Two frames inside a third: the LEN of each is at least this much less than that of the third. The other one has at least
// `overhead` bytes, and one byte of the third precedes them and one follows.
constexpr std::size_t shorter_at_least = overhead + 2;

// Most positions are empty, so they are skipped one machine word at a time.
std::uint64_t load_word(const void* from) noexcept {
    std::uint64_t word;
    std::memcpy(&word, from, sizeof word);
    return word;
}

// The highest bit of each of the eight bytes that is HEAD; the first byte is the lowest byte of the result.
std::uint64_t heads_among(const std::uint8_t* eight) noexcept {
    constexpr std::uint64_t ones = 0x0101010101010101;
    constexpr std::uint64_t low = 0x7F * ones;
    std::uint64_t x = load_word(eight) ^ ones * head;
    if constexpr (std::endian::native == std::endian::big) x = __builtin_bswap64(x);
    return ~(((x & low) + low) | x | low);
}

}    // namespace

// A search covers less than the size of the largest frame, and its candidates end less than that size after it.
FramePairs::FramePairs(std::size_t max_data)
    : max_data_{max_data},
      mask_{std::bit_ceil(std::max<std::size_t>(1, 2 * std::min(max_data, max_len))) - 1},
      ends_{mask_ + 1},
      nexts_{mask_ + 1},
      forgotten_{0 - static_cast<Place>(mask_) - 1} {}    // one ring length back, so that the first search clears the ring

bool FramePairs::stand_behind(std::size_t at, std::span<const std::uint8_t> bytes, const PrefixSums& sums,
                              const Heard& heard) noexcept {
    const Place place = origin_ + at;
    const Place end = origin_ + bytes.size();
    if (judged_until_ != end) {    // otherwise no byte arrived since the last search
        forget_until(place);
        headers_until_ = std::max(headers_until_, place + 1);
        judged_until_ = std::max(judged_until_, place);
        if (!note_headers(at, bytes, sums, heard)) return false;
        check_until(end, place, bytes, sums);
    }
    if (latest_ <= place || !can_look()) return false;
    credit_ -= a_look;
    return true;
}

void FramePairs::forget_until(Place place) noexcept {
    const Place round = mask_ + 1;
    if (place - forgotten_ > round) forgotten_ = place - round;
    while (forgotten_ != place) {
        const std::size_t from = in_ring(forgotten_ + 1);
        const auto n = static_cast<std::size_t>(std::min(place - forgotten_, round - from));
        std::memset(&ends_[from], 0, n * sizeof ends_[0]);
        forgotten_ += n;
    }
}

// False: the credit is not enough. No candidate may be checked before all headers are stored.
bool FramePairs::note_headers(std::size_t waiting, std::span<const std::uint8_t> bytes, const PrefixSums& sums,
                              const Heard& heard) noexcept {
    const std::size_t max_length = std::min(data_length(bytes.data() + waiting), max_data_);
    const std::size_t whole = bytes.size() - (header_size - 1);    // no complete header begins here or later
    auto at = static_cast<std::size_t>(headers_until_ - origin_);
    for (; at < whole; at += 8) {
        std::uint64_t heads = heads_among(bytes.data() + at);
        if (whole - at < 8) heads &= (std::uint64_t{1} << 8 * (whole - at)) - 1;
        for (; heads != 0; heads &= heads - 1) {
            const std::size_t begin = at + static_cast<unsigned>(std::countr_zero(heads)) / 8;
            if (!can_look()) {
                headers_until_ = origin_ + begin;
                return false;
            }
            credit_ -= a_look;
            const std::uint8_t* const header = bytes.data() + begin;
            const std::size_t length = data_length(header);
            if (!heard.source(header[1]) || length + shorter_at_least > max_length || begin + length >= waiting + max_length)
                continue;
            const std::size_t sum_place = begin + header_size + length;
            if (sum_place + 2 <= bytes.size() && !sums.sum_holds(begin, sum_place)) continue;    // the sum is already wrong
            const Place place = origin_ + begin;
            std::uint16_t& first = size_at(place + overhead + length);
            nexts_[in_ring(place)] = first;
            first = static_cast<std::uint16_t>(overhead + length);
        }
    }
    headers_until_ = std::max(headers_until_, origin_ + whole);
    return true;
}

void FramePairs::check_until(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept {
    constexpr Place sizes_a_word = sizeof(std::uint64_t) / sizeof ends_[0];
    while (judged_until_ < end) {
        const Place next = judged_until_ + 1;
        if (next % sizes_a_word == 0 && next + sizes_a_word <= end && mask_ >= sizes_a_word && load_word(&size_at(next)) == 0) {
            judged_until_ += sizes_a_word;
        } else {
            judged_until_ = next;
            if (size_at(next) != 0) check_what_ends(next, behind, bytes, sums);
        }
    }
}

// Candidates that begin at `behind` or before are no longer needed, and their bytes may be overwritten.
void FramePairs::check_what_ends(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept {
    const auto sum_place = static_cast<std::size_t>(end - origin_) - 2;
    std::uint16_t good = 0;
    for (std::uint16_t size = size_at(end); size != 0 && end - size > behind; size = nexts_[in_ring(end - size)]) {
        const Place begin = end - size;
        const auto at = static_cast<std::size_t>(begin - origin_);
        if (!sums.sum_holds(at, sum_place) || sums.add(at, sum_place) != bytes[sum_place + 1]) continue;
        if (good == 0) good = size;
        if (const std::uint16_t before = size_at(begin)) latest_ = std::max(latest_, begin - before);
    }
    size_at(end) = good;
}

}    // namespace ano
