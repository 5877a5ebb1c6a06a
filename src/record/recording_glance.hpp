// What a recording tells by its two ends, without reading what is between them. No I/O.
#pragma once
#include <record/recording_writer.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace anogate {

struct RecordingGlance {
    RecordingHead head;    // without a program: it is no recording, or not one of ours
    bool is_ended = false;
    std::optional<std::uint64_t> frames;    // where its end tells; of MCAP read_mcap_index() does
    /// From its first frame to its last, where its ends tell; by the clock that nobody sets, where it has that. Of MCAP as well.
    std::optional<double> seconds;
};

/// So many bytes of each end are enough; a file that has fewer is given as both.
inline constexpr std::size_t glance_size = 16 * 1024;
RecordingGlance glance_at(RecordingFormat format, std::string_view first, std::string_view last);

}    // namespace anogate
