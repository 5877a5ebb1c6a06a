// Describes a ROS 2 message type. Its definition text and the encoders are derived from this.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

enum class RosType : std::uint8_t {
    boolean,
    byte,    // as uint8, except in the hash of a type
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64,
    text,
    message
};

/// "float64"; empty for a message.
std::string_view name_of(RosType type) noexcept;

struct RosMessage;

/// A named value. It precedes a field and has the type of that field.
struct RosConstant {
    std::string name;
    std::int64_t value = 0;
};

struct RosField {
    enum class Shape : std::uint8_t { one, array, sequence };

    RosType type = RosType::float64;
    std::string name;
    Shape shape = Shape::one;
    std::size_t count = 1;                  // elements of an array
    const RosMessage* message = nullptr;    // if type is RosType::message; must outlive this
    std::vector<RosConstant> constants{};
    std::string comment{};    // one line
};

struct RosMessage {
    std::string package;    // "sensor_msgs"
    std::string name;       // "Imu"
    std::string comment{};
    std::vector<RosField> fields{};
};

/// "sensor_msgs/msg/Imu"
std::string full_name(const RosMessage& message);

/// The definition in the format `ros2msg`: the fields of the message, then those of every nested message, each after a line of 80 "=".
/// A message without fields gets the dummy field that ROS 2 adds.
std::string definition_of(const RosMessage& message);

}    // namespace anogate
