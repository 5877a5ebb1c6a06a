#include <ano/frame_pairs.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

namespace ano {
namespace {

// Two frames inside a third are shorter than it by this much, each.
constexpr std::size_t shorter_at_least = overhead + 2;

}    // namespace

// What is asked for stands in less than a largest frame, and its candidates end less than one behind that.
FramePairs::FramePairs(std::size_t max_data)
    : max_data_{std::min(max_data, largest_data)},
      mask_{std::bit_ceil(std::max<std::size_t>(1, 2 * max_data_)) - 1},
      ends_{new std::uint16_t[mask_ + 1]},
      nexts_{new std::uint16_t[mask_ + 1]},
      forgotten_{0 - static_cast<Place>(mask_) - 1} {}    // a whole round back: the first search clears the ring

bool FramePairs::stand_behind(std::size_t at, std::span<const std::uint8_t> bytes, const PrefixSums& sums,
                              const Heard& heard) noexcept {
    const Place place = origin_ + at;
    forget_until(place);
    headers_until_ = std::max(headers_until_, place + 1);
    judged_until_ = std::max(judged_until_, place);
    note_headers(bytes, heard);
    for (const Place end = origin_ + bytes.size(); judged_until_ < end;)
        if (size_at(++judged_until_) != 0) judge_what_ends(judged_until_, place, bytes, sums);
    return latest_ > place;
}

void FramePairs::forget_until(Place place) noexcept {
    const Place round = mask_ + 1;
    if (place - forgotten_ > round) forgotten_ = place - round;
    while (forgotten_ != place) {
        const Place from = (forgotten_ + 1) & mask_;
        const Place n = std::min(place - forgotten_, round - from);
        std::memset(&ends_[from], 0, n * sizeof ends_[0]);
        forgotten_ += n;
    }
}

void FramePairs::note_headers(std::span<const std::uint8_t> bytes, const Heard& heard) noexcept {
    const std::size_t whole = bytes.size() - (header_size - 1);    // no whole header begins there or behind
    std::size_t at = static_cast<std::size_t>(headers_until_ - origin_);
    for (; at < whole; ++at) {
        const std::uint8_t* const header = bytes.data() + at;
        if (*header != head || !heard.source(header[1])) continue;
        const std::size_t length = data_length(header);
        if (length + shorter_at_least > max_data_) continue;
        const Place begin = origin_ + at;
        std::uint16_t& first = size_at(begin + overhead + length);
        nexts_[begin & mask_] = first;
        first = static_cast<std::uint16_t>(overhead + length);
    }
    headers_until_ = origin_ + at;
}

// Those that begin at `behind` or before are of no use any more, and their bytes may be gone.
void FramePairs::judge_what_ends(Place end, Place behind, std::span<const std::uint8_t> bytes,
                                 const PrefixSums& sums) noexcept {
    const auto sum_place = static_cast<std::size_t>(end - origin_) - 2;
    std::uint16_t good = 0;
    for (std::uint16_t size = size_at(end); size != 0 && end - size > behind; size = nexts_[(end - size) & mask_]) {
        const Place begin = end - size;
        const auto at = static_cast<std::size_t>(begin - origin_);
        if (!sums.sum_holds(at, sum_place) || sums.add(at, sum_place) != bytes[sum_place + 1]) continue;
        if (good == 0) good = size;
        if (const std::uint16_t before = size_at(begin)) latest_ = std::max(latest_, begin - before);
    }
    size_at(end) = good;
}

}    // namespace ano
