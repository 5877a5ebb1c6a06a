// Finds two good frames in a row among bytes that come in pieces, however long the frames are that only seem to begin there.
#pragma once
#include <ano/heard.hpp>
#include <ano/prefix_sums.hpp>
#include <ano/room.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ano {

/// Looks at each byte once: what begins somewhere is kept by the place where it would end, until that byte is there.
/// What it may cost is earned: 32 bytes of good frames pay for a look at one header, or for one candidate that gives way;
/// 65536 bytes are saved at the most, and are there at first. So false headers among frames give way at once, and in a
/// flood of headers a candidate waits as if there were no search.
/// Neither throws nor allocates after construction; memory that no search has needed is never touched.
class FramePairs {
public:
    explicit FramePairs(std::size_t max_data);

    /// Whether the candidate at `at` gives way: two good frames stand in a row behind its first byte. `bytes` is the
    /// buffer up to where it is filled, and summed; 8 bytes more must be readable. It has the candidate's header, but not
    /// all of the frame. `at` never goes back in the stream. When a header is first looked at it is decided whether its
    /// frame counts: when its source has been heard and it would end before the candidate does. While that cannot be paid
    /// for the answer is no; what was not looked at is looked at later, if a candidate before it still waits then.
    bool stand_behind(std::size_t at, std::span<const std::uint8_t> bytes, const PrefixSums& sums, const Heard& heard) noexcept;
    /// A good frame of `size` bytes came.
    void earn(std::size_t size) noexcept { credit_ = std::min(credit_ + size, max_credit); }
    /// Whether a look can be paid for; while not, stand_behind() need not be asked.
    bool can_look() const noexcept { return credit_ >= a_look; }
    /// The buffer's content moved to its front by `distance` bytes.
    void move_front(std::size_t distance) noexcept { origin_ += distance; }

private:
    static constexpr std::size_t a_look = 32;    // bytes of good frames, like all credit
    static constexpr std::size_t max_credit = 65536;

    // A place in the stream, not in the buffer.
    using Place = std::uint64_t;

    void forget_until(Place place) noexcept;
    bool note_headers(std::size_t waiting, std::span<const std::uint8_t> bytes, const PrefixSums& sums,
                      const Heard& heard) noexcept;
    void check_until(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept;
    void check_what_ends(Place end, Place behind, std::span<const std::uint8_t> bytes, const PrefixSums& sums) noexcept;
    std::uint16_t& size_at(Place end) noexcept { return ends_[end & mask_]; }

    // Both are rings over the stream. Of what ends, or would end, at a place, the latest to begin comes first; it is told
    // by its size, which the place where it ends makes a place where it begins.
    std::size_t mask_;
    Room<std::uint16_t> ends_;     // by end: the first candidate; once it was judged, the first good frame
    Room<std::uint16_t> nexts_;    // by begin: the next candidate of the same end

    std::size_t credit_ = max_credit;
    Place origin_ = 0;           // of the buffer's first byte
    Place forgotten_;            // nothing is known of what ends here or before
    Place headers_until_ = 0;    // the headers that begin before were looked at
    Place judged_until_ = 0;     // the candidates that end here or before were judged
    Place latest_ = 0;           // where the last pair begins
};

}    // namespace ano
