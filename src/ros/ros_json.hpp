// The values of a ROS message as JSON in the form of rosbridge: names of the definition, plain numbers, bytes as base64. A number
// that is not finite has no key, because programs that read these schemas do not support null; in an array it is null.
#pragma once
#include <ano/reading.hpp>
#include <ros/ros_message.hpp>

#include <span>
#include <string>

namespace anogate {

/// Appends the message. `values`: as for CdrEncoder::encode().
void write_ros_json(const RosMessage& message, std::span<const ano::Value> values, std::string& out);

/// The JSON Schema of the messages that write_ros_json() writes.
std::string ros_json_schema(const RosMessage& message);

}    // namespace anogate
