// Finds the frames in a block of memory, and the bytes between them.
#pragma once
#include <ano/parser.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ano {

/// Calls `on_frame(FrameView)` for each valid frame and `on_gap(offset, bytes)` for bytes that belong to no frame, in their order
/// in memory. Linear time.
template <class OnFrame, class OnGap>
void split_frames(std::span<const std::uint8_t> bytes, OnFrame&& on_frame, OnGap&& on_gap) {
    FrameParser::Options options;
    options.max_data = std::min(bytes.size(), max_len);
    FrameParser parser{options};
    std::size_t offset = 0;
    std::size_t at = 0;      // end of the reported bytes
    std::size_t good = 0;    // bytes of valid frames
    const auto gap_until = [&](std::size_t end) {
        if (end > at) on_gap(at, bytes.subspan(at, end - at));
        at = end;
    };
    while (offset < bytes.size()) {
        const auto room = parser.prepare();
        const std::size_t n = std::min(room.size(), bytes.size() - offset);
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), n, room.begin());
        parser.commit(n, TimePoint{});
        offset += n;
        if (offset == bytes.size()) parser.finish();
        while (const auto frame = parser.next()) {
            gap_until(good + static_cast<std::size_t>(parser.counters().skipped_bytes));
            on_frame(*frame);
            good += frame->bytes().size();
            at += frame->bytes().size();
        }
    }
    gap_until(bytes.size());
}

}    // namespace ano
