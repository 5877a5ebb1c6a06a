// The topics of a device: their names, types and sources.
#pragma once
#include <ros/ros_message.hpp>
#include <ros/standard_messages.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

struct TopicRow {
    std::string_view name;    // without the prefix
    const RosMessage* type;
    std::span<const std::uint8_t> sources;    // ids of messages
    std::string_view needs;                   // why it may be silent although a source was received; empty: never
};

/// The first ones in the order of StandardTopic.
std::span<const TopicRow> topic_table();
inline constexpr std::size_t joy_topic = standard_topics, log_topic = standard_topics + 1, device_topics = standard_topics + 2;

/// Those of the table, "raw" for all topics under raw/, "tf" and "diagnostics".
std::span<const std::string_view> topic_names();

/// "0x04 quaternion, 0x03 euler"
std::string format_sources(const TopicRow& row);

}    // namespace anogate
