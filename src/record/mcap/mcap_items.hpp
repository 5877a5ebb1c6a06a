// Frames and losses as messages of MCAP: little-endian CDR with ros2msg schemas, which other programs can show.
#pragma once
#include <record/mcap/mcap_format.hpp>
#include <record/recording.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::mcap {

inline constexpr std::string_view frame_schema_name = "ano_msgs/msg/RecordedFrame";
inline constexpr std::string_view frame_schema_text =
    "# A frame of ANO V8 as it passed the gateway; its time is that of the message\n"
    "uint8 IN=0\n"
    "uint8 OUT=1\n"
    "uint8 DROPPED=2\n"
    "uint64 boottime_ns       # since the computer was started; 0: not known\n"
    "string link              # by name\n"
    "string link_description  # empty: not known\n"
    "uint8 direction\n"
    "string cause             # why it was dropped\n"
    "int16 channel            # its number in the gateway; -1: none\n"
    "string peer              # of that channel\n"
    "uint8[] frame            # from 0xAB to the check bytes\n";

inline constexpr std::string_view loss_schema_name = "ano_msgs/msg/RecordedLoss";
inline constexpr std::string_view loss_schema_text =
    "# Frames that were not recorded, between the frame before and the one behind\n"
    "uint64 count\n"
    "string names             # euler 120, inertial 120\n";

/// Sets `out` to the encoded message. Texts are cut after max_recorded_text bytes.
void encode(const RecordedFrame& frame, std::string& out);
void encode(const RecordedLoss& loss, std::string& out);

/// Finds frames and losses among the messages of a file, no matter which program wrote it.
class Items {
public:
    void add_channel(std::string_view body);
    /// Refers to the memory of the message. std::nullopt: the message is of another channel, or damaged.
    std::optional<Recorded> item_of(const Message& message);
    /// Call this if Channel records may be in an unreadable part: from then on an unknown channel counts as a channel of frames
    /// if one of its messages is a frame.
    void miss_channels() noexcept { misses_channels_ = true; }
    bool has_frames(std::uint16_t channel) const noexcept;

    /// Whether there was a channel of frames.
    bool has_channel() const noexcept { return has_channel_; }
    /// Number of messages on channels of frames that are not complete frames.
    std::uint64_t foreign() const noexcept { return foreign_; }

private:
    enum class Kind : std::uint8_t { unknown, other, frames, losses };
    Kind kind_of(std::uint16_t channel) const noexcept;
    void set_kind(std::uint16_t channel, Kind kind);

    std::vector<Kind> kinds_;    // by channel
    bool has_channel_ = false, misses_channels_ = false;
    std::uint64_t foreign_ = 0;
};

}    // namespace anogate::mcap
