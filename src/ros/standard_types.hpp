// The ROS 2 (Jazzy) messages to which messages of the protocol are converted.
#pragma once
#include <ros/ros_message.hpp>

namespace anogate {

/// Valid as long as the program runs.
struct StandardTypes {
    const RosMessage *imu, *magnetic_field, *temperature, *nav_sat_fix, *battery_state, *range, *quaternion_stamped,
        *vector3_stamped, *point_stamped, *odometry, *point_cloud, *image, *joy, *twist, *string, *log, *diagnostic_array,
        *tf_message;
};
const StandardTypes& standard_types();

}    // namespace anogate
