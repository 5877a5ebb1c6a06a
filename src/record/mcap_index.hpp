// What a recording of MCAP comes to, by its end alone: however long it is, little of it is read. No I/O.
#pragma once
#include <record/recording_counts.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace anogate {

struct McapIndex {
    RecordingHead head;
    RecordingCounts counts;
};

/// Gives the bytes of the file from `at` on, `size` or fewer; none: there are no more, or they can't be read.
using ReadAt = std::function<std::string(std::uint64_t at, std::size_t size)>;

/// Nothing: the file was not ended, is damaged there, or another program saved it. Then all of it has to be read.
std::optional<McapIndex> read_mcap_index(std::uint64_t file_size, const ReadAt& read);

}    // namespace anogate
