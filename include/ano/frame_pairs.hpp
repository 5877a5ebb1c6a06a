// Finds two consecutive valid frames after the start of a candidate (a HEAD that may begin a frame) whose rest was not received
// yet. The bytes arrive in pieces, and the LEN of candidates may be large.
#pragma once
#include <ano/heard.hpp>
#include <ano/lazy_array.hpp>
#include <ano/prefix_sums.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ano {

/// Reads each byte once. A header is stored at the place where its frame would end, and is checked when that byte has arrived. A
/// credit limits the cost: 32 bytes of valid frames pay for examining one header, or for giving up one candidate. The credit is
/// at most 65536 bytes, and full at first. So false headers among valid frames are given up at once. In a flood of headers the
/// credit is used up, and a candidate waits as if there were no search. Neither throws nor allocates after construction. Memory
/// that no search needs is never accessed.
class FramePairs {
public:
    explicit FramePairs(std::size_t max_data);

    /// Whether the candidate at `at` is given up: two consecutive valid frames follow its first byte. `bytes` is the filled part
    /// of the buffer, up to the end of a possible frame with max_data; 8 bytes after it must be readable. It contains the header
    /// of the candidate, but not all of its frame. `sums` cover all of `bytes`. `at` never goes back in the stream. A header
    /// counts if, when it is first examined, its source is in `heard` and its frame would end before the candidate does. Without
    /// credit the result is false. Headers that were not examined are examined later, if a candidate before them still waits
    /// then.
    bool stand_behind(std::size_t at, std::span<const std::uint8_t> bytes, const PrefixSums& sums, const Heard& heard) noexcept;
    /// A valid frame of `size` bytes was received.
    void earn(std::size_t size) noexcept { credit_ = std::min(credit_ + size, max_credit); }
    /// Whether the credit is enough for examining one header; otherwise stand_behind() need not be called.
    bool can_look() const noexcept { return credit_ >= a_look; }
    /// The content of the buffer was moved to its beginning, by `distance` bytes.
    void move_front(std::size_t distance) noexcept { origin_ += distance; }

private:
    static constexpr std::size_t a_look = 32;    // the price of examining one header; all credit is in bytes of valid frames
    static constexpr std::size_t max_credit = 65536;

    // A position in the stream, not in the buffer.
    using Place = std::uint64_t;

    void forget_until(Place place) noexcept;
    bool note_headers(std::size_t waiting, std::span<const std::uint8_t> bytes, const PrefixSums& sums,
                      const Heard& heard) noexcept;
    void check_until(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept;
    void check_what_ends(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept;
    std::size_t in_ring(Place place) const noexcept { return static_cast<std::size_t>(place & mask_); }
    std::uint16_t& size_at(Place end) noexcept { return ends_[in_ring(end)]; }

    // ends_ and nexts_ are rings, indexed by positions in the stream. Among frames with the same end, the one that begins last is
    // first in the list. A frame is stored as its size: its distance from begin to end.
    std::size_t max_data_;
    std::size_t mask_;
    LazyArray<std::uint16_t> ends_;     // by end: the first candidate; after the check the first valid frame
    LazyArray<std::uint16_t> nexts_;    // by begin: the next candidate with the same end

    std::size_t credit_ = max_credit;
    Place origin_ = 0;           // position of the first byte of the buffer
    Place forgotten_;            // frames that end here or before were removed
    Place headers_until_ = 0;    // the headers that begin before this were examined
    Place judged_until_ = 0;     // the candidates that end here or before were checked
    Place latest_ = 0;           // where the last found pair begins
};

}    // namespace ano
