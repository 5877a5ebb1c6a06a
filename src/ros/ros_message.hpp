// A message type of ROS 2 as a description, from which its definition and the encoder of its values come.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

enum class RosType : std::uint8_t {
    boolean,
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

/// A value with a name, of the type of the field that it stands before.
struct RosConstant {
    std::string name;
    std::int64_t value = 0;
};

struct RosField {
    enum class Shape : std::uint8_t { one, array, sequence };

    RosType type = RosType::float64;
    std::string name;
    Shape shape = Shape::one;
    std::size_t count = 1;                  // of an array
    const RosMessage* message = nullptr;    // where the type is one; outlives this
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

/// The definition as `ros2msg` has it: the fields of the message, and behind it, each behind a line of 80 "=", those of every message in
/// it. A message without fields has the one that ROS 2 gives it.
std::string definition_of(const RosMessage& message);

}    // namespace anogate
