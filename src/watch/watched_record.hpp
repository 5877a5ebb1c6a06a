// Converts the records of a watcher into those of a recording.
#pragma once
#include <gateway/frame_record.hpp>
#include <record/recording.hpp>
#include <watch/watch_queue.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class Gateway;

/// The names for the numbers in records; the index in a vector is the number.
struct RecordedNames {
    std::vector<std::string> links, kinds;    // of the links
    std::vector<std::string> peers;           // of the channels
    DecodingPtr decoding{};                   // of the records

    /// The approximate memory, in bytes.
    std::size_t cost() const noexcept;
};
RecordedNames recorded_names(const WatchTables& tables, const Gateway& gateway);

/// A watched frame. Valid as long as `record` and `names`.
RecordedFrame as_recorded(const FrameRecord& record, const RecordedNames& names);
/// The same, without a description of its link.
RecordedFrame as_recorded(const FrameRecord& record, const WatchTables& tables);

std::uint64_t count_of_records(std::string_view records) noexcept;

/// "euler 120, inertial 120"
std::string loss_names(const LostFrames& lost);
/// The header for a recording that begins now.
RecordingHead recording_head(DecodingPtr decoding = {});

}    // namespace anogate
