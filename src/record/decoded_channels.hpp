// Decodes frames into messages on channels with schemas, as MCAP and Foxglove use them. No I/O.
//
// Flow:    DecodedChannels decoded{DecodedEncoding::cdr};
//          for (const DecodedMessage& message : decoded.decode(frame)) {
//              const DecodedChannel& channel = decoded.channels()[message.channel];     // announce a new one first, with its schema
//              const DecodedSchema& schema = decoded.schemas()[channel.schema];
//          }
//
// Only received frames are decoded: sent and dropped frames were received before and would appear twice. A topic is
// /LINK/device_ADDR/NAME, with names that ROS 2 allows. For the contents of the messages see src/ros/README.md.
#pragma once
#include <record/decoding.hpp>
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

/// "cdr", "json": the names of the encodings in MCAP and Foxglove.
std::string_view text(DecodedEncoding encoding) noexcept;
std::optional<DecodedEncoding> decoded_encoding_called(std::string_view name) noexcept;

struct DecodedSchema {
    std::string name;        // "ano_msgs/msg/Euler"
    std::string encoding;    // "ros2msg" or "jsonschema"
    std::string text;        // including the definitions it uses
};

struct DecodedChannel {
    std::string topic;         // "/fc/device_5/euler"
    std::size_t schema = 0;    // index in schemas()
};

struct DecodedMessage {
    std::size_t channel = 0;    // index in channels()
    std::string_view data;
};

/// Channels are numbered in the order of their first message; a number never changes its meaning.
class DecodedChannels {
public:
    static constexpr std::size_t max_channels = 4096;    // messages of further channels are not decoded

    /// Flexible messages without a layout in `decoding` are not decoded.
    explicit DecodedChannels(DecodedEncoding encoding, DecodingPtr decoding = {});
    ~DecodedChannels();
    DecodedChannels(const DecodedChannels&) = delete;
    DecodedChannels& operator=(const DecodedChannels&) = delete;

    /// Sets the decoding of the frames that follow. A flexible message whose layout may have changed gets a new channel with the
    /// same topic.
    void use(DecodingPtr decoding);

    /// Returns no message for a frame that is not in the table of messages, and several if standard ROS messages match besides
    /// our own. Valid until the next call.
    std::span<const DecodedMessage> decode(const RecordedFrame& frame);

    const std::deque<DecodedSchema>& schemas() const noexcept;
    const std::deque<DecodedChannel>& channels() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}    // namespace anogate
