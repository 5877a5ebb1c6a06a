// What a watcher of the gateway gets, in the words of a recording.
#pragma once
#include <daemon/watch_queue.hpp>
#include <gateway/frame_record.hpp>
#include <record/recording.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class Gateway;

/// What the numbers in records mean, by number.
struct RecordedNames {
    std::vector<std::string> links, kinds;    // of the links
    std::vector<std::string> peers;           // of the channels

    /// Bytes of memory, about.
    std::size_t cost() const noexcept;
};
RecordedNames recorded_names(const WatchTables& tables, const Gateway& gateway);

/// A frame that was watched. Valid as long as both.
RecordedFrame as_recorded(const FrameRecord& record, const RecordedNames& names);
/// Without a description of its link.
RecordedFrame as_recorded(const FrameRecord& record, const WatchTables& tables);

std::uint64_t count_of_records(std::string_view records) noexcept;

/// "euler 120, inertial 120"
std::string loss_names(const LostFrames& lost);
/// What the gateway says of itself now.
RecordingHead recording_head();

}    // namespace anogate
