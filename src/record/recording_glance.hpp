// Facts from the beginning and the end of a recording, without reading the rest. No I/O.
#pragma once
#include <record/recording_writer.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace anogate {

struct RecordingGlance {
    RecordingHead head;    // an empty program: not a recording of anogate
    bool is_ended = false;
    std::optional<std::uint64_t> frames;    // if the end contains it; for MCAP use read_mcap_index()
    /// From the first frame to the last, if both times are known; by the boot-time clock if the recording has it. MCAP: as for
    /// `frames`.
    std::optional<double> seconds;
};

/// Bytes needed of each end; a smaller file is passed as both.
inline constexpr std::size_t glance_size = 16 * 1024;
RecordingGlance glance_at(RecordingFormat format, std::string_view first, std::string_view last);

}    // namespace anogate
