// What frames say, as messages on channels with schemas, as MCAP and Foxglove have them. No I/O.
//
// Flow:    DecodedChannels decoded{DecodedEncoding::cdr};
//          for (const DecodedMessage& message : decoded.decode(frame)) {
//              const DecodedChannel& channel = decoded.channels()[message.channel];     // tell it, and its schema, before its first message
//              const DecodedSchema& schema = decoded.schemas()[channel.schema];
//          }
//
// What came in is decoded; what left or was dropped is not: it came in before, and would be told twice. A topic is /LINK/device_ADDR/NAME,
// its names as ROS 2 allows them. What stands in the messages: src/ros/README.md.
#pragma once
#include <ano/flexible.hpp>
#include <record/recording.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

enum class DecodedEncoding : std::uint8_t { cdr, json };

/// "cdr", "json": as MCAP and Foxglove call the encoding of messages.
std::string_view text(DecodedEncoding encoding) noexcept;
std::optional<DecodedEncoding> decoded_encoding_called(std::string_view name) noexcept;

struct DecodedSchema {
    std::string name;        // "ano_msgs/msg/Euler"
    std::string encoding;    // "ros2msg" or "jsonschema"
    std::string text;        // with the definitions that it needs
};

struct DecodedChannel {
    std::string topic;         // "/fc/device_5/euler"
    std::size_t schema = 0;    // in schemas()
};

struct DecodedMessage {
    std::size_t channel = 0;    // in channels()
    std::string_view data;
};

/// Channels are numbered as they come; a number keeps its meaning.
class DecodedChannels {
public:
    static constexpr std::size_t max_channels = 4096;    // what would be one more is not decoded

    /// `flexible`, which outlives it, has the layouts of flexible messages; frames of those without a layout are not decoded.
    explicit DecodedChannels(DecodedEncoding encoding, const ano::FlexibleLayouts* flexible = nullptr);
    ~DecodedChannels();
    DecodedChannels(const DecodedChannels&) = delete;
    DecodedChannels& operator=(const DecodedChannels&) = delete;

    /// None for a frame that the table of messages does not have; several where a message of ROS fits beside ours. Valid until the
    /// next call.
    std::span<const DecodedMessage> decode(const RecordedFrame& frame);

    const std::deque<DecodedSchema>& schemas() const noexcept;
    const std::deque<DecodedChannel>& channels() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}    // namespace anogate
