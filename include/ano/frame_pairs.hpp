// Finds two good frames in a row behind a candidate (a HEAD that may begin a frame) whose rest has not come yet. The
// bytes come in pieces, and candidates may claim to be long.
#pragma once
#include <ano/heard.hpp>
#include <ano/prefix_sums.hpp>
#include <ano/room.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ano {

/// Reads each byte once: a header is noted at the place where its frame would end, and is checked when that byte is there.
/// Cost is limited by a credit: 32 bytes of good frames pay for looking at one header, or for one candidate that gives way.
/// The credit is at most 65536 bytes, and begins full. So false headers among good frames give way at once; in a flood of
/// headers the credit runs out, and a candidate waits as if there were no search.
/// Neither throws nor allocates after construction; memory that no search has needed is never touched.
class FramePairs {
public:
    explicit FramePairs(std::size_t max_data);

    /// Whether the candidate at `at` gives way: two good frames stand in a row behind its first byte. `bytes` is the
    /// filled part of the buffer, as far as a frame of max_data may reach, and `sums` cover all of it; 8 bytes behind it must be readable. It holds the candidate's
    /// header, but not all of its frame. `at` never goes back in the stream. A header's frame counts when, at the first look
    /// at it, its source has been heard and it would end before the candidate does. Without credit the answer is no; headers
    /// that were not looked at are looked at later, if a candidate before them still waits then.
    bool stand_behind(std::size_t at, std::span<const std::uint8_t> bytes, const PrefixSums& sums, const Heard& heard) noexcept;
    /// A good frame of `size` bytes came.
    void earn(std::size_t size) noexcept { credit_ = std::min(credit_ + size, max_credit); }
    /// Whether there is credit for a look; without it stand_behind() need not be called.
    bool can_look() const noexcept { return credit_ >= a_look; }
    /// The buffer's content moved to its front by `distance` bytes.
    void move_front(std::size_t distance) noexcept { origin_ += distance; }

private:
    static constexpr std::size_t a_look = 32;    // the price of one look; all credit is in bytes of good frames
    static constexpr std::size_t max_credit = 65536;

    // A place in the stream, not in the buffer.
    using Place = std::uint64_t;

    void forget_until(Place place) noexcept;
    bool note_headers(std::size_t waiting, std::span<const std::uint8_t> bytes, const PrefixSums& sums,
                      const Heard& heard) noexcept;
    void check_until(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept;
    void check_what_ends(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept;
    std::size_t in_ring(Place place) const noexcept { return static_cast<std::size_t>(place & mask_); }
    std::uint16_t& size_at(Place end) noexcept { return ends_[in_ring(end)]; }

    // ends_ and nexts_ are rings, indexed by places in the stream. Of the frames that end at one place, the one that begins last
    // is first in the list. A frame is stored as its size: it begins that far before the place where it ends.
    std::size_t max_data_;
    std::size_t mask_;
    Room<std::uint16_t> ends_;     // by end: the first candidate; once it was judged, the first good frame
    Room<std::uint16_t> nexts_;    // by begin: the next candidate of the same end

    std::size_t credit_ = max_credit;
    Place origin_ = 0;           // of the buffer's first byte
    Place forgotten_;            // frames that end here or before are forgotten
    Place headers_until_ = 0;    // the headers that begin before were looked at
    Place judged_until_ = 0;     // the candidates that end here or before were judged
    Place latest_ = 0;           // where the last pair begins
};

}    // namespace ano
