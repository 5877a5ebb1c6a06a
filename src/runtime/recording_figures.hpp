// The sums over all recordings of a gateway since it started.
#pragma once
#include <cstdint>
#include <optional>

namespace anogate {

struct RecordingFigures {
    std::uint64_t running = 0, failing = 0;    // recordings; `failing`: those that can't be written at present
    std::uint64_t frames = 0, bytes = 0;
    std::uint64_t not_written = 0;                        // frames
    std::optional<std::uint64_t> free{};                  // bytes of their disk; std::nullopt: not known
    std::uint64_t memory_frames = 0, memory_bytes = 0;    // of keep_last
    std::uint64_t saved = 0, skipped = 0;                 // how often keep_last was saved, and not saved because it just had been
};

}    // namespace anogate
