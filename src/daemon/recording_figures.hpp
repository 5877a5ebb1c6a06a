// What the recordings of a gateway come to since it started.
#pragma once
#include <cstdint>
#include <optional>

namespace anogate {

struct RecordingFigures {
    std::uint64_t running = 0, failing = 0;    // recordings; of them, those of which nothing is written now
    std::uint64_t frames = 0, bytes = 0;
    std::uint64_t not_written = 0;                        // frames
    std::optional<std::uint64_t> free{};                  // bytes of their disk; nothing: it is not known
    std::uint64_t memory_frames = 0, memory_bytes = 0;    // of keep_last
    std::uint64_t saved = 0, skipped = 0;                 // times that keep_last was saved, and was not: it had been a moment ago
};

}    // namespace anogate
