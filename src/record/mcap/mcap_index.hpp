// The totals of an MCAP recording, read from its end: only a small part of a long file is read. No I/O.
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

/// Returns up to `size` bytes of the file from offset `at`; empty: end of the file, or a read error.
using ReadAt = std::function<std::string(std::uint64_t at, std::size_t size)>;

/// std::nullopt: the file was not ended properly, its end is damaged, or another program saved it. Then the whole file must be
/// read.
std::optional<McapIndex> read_mcap_index(std::uint64_t file_size, const ReadAt& read);

}    // namespace anogate
