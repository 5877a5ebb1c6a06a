// The values of a ROS message as JSON, as rosbridge has them: the names of the definition, numbers as such, bytes as base64. What is no
// finite number has no key, and is null among others in an array: the programs that read these schemas know no type that may be null.
#pragma once
#include <ano/reading.hpp>
#include <ros/ros_message.hpp>

#include <span>
#include <string>

namespace anogate {

/// `values` as of CdrEncoder::encode().
std::string ros_json(const RosMessage& message, std::span<const ano::Value> values);

/// The JSON Schema for that.
std::string ros_json_schema(const RosMessage& message);

}    // namespace anogate
