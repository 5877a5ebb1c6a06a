// The hash by which ROS 2 (from Iron on) compares the definitions of a type: RIHS01 of REP 2011.
#pragma once
#include <ros/ros_message.hpp>

#include <string>

namespace anogate {

/// "RIHS01_7d9a00ff…": SHA-256 of the description of the type and of all types that it contains.
std::string type_hash(const RosMessage& message);

/// The name of the type in DDS: "sensor_msgs::msg::dds_::Imu_".
std::string dds_type_name(const RosMessage& message);

}    // namespace anogate
