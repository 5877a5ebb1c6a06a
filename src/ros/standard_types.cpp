#include <ros/standard_types.hpp>

#include <initializer_list>
#include <string>
#include <utility>

namespace anogate {
namespace {

using Shape = RosField::Shape;

RosField numbers(RosType type, const char* name, std::size_t count) {
    return {.type = type, .name = name, .shape = Shape::array, .count = count};
}
RosField sequence(RosType type, const char* name) { return {.type = type, .name = name, .shape = Shape::sequence}; }
RosField one(const RosMessage& message, const char* name) {
    return {.type = RosType::message, .name = name, .message = &message};
}
RosField one(RosType type, const char* name, std::vector<RosConstant> constants = {}) {
    return {.type = type, .name = name, .constants = std::move(constants)};
}
RosField list_of(const RosMessage& message, const char* name) {
    return {.type = RosType::message, .name = name, .shape = Shape::sequence, .message = &message};
}
RosMessage made_of(const char* package, const char* name, std::vector<RosField> fields) {
    return {.package = package, .name = name, .comment = {}, .fields = std::move(fields)};
}

// The order matters: a definition refers only to those before it.
struct Definitions {
    using enum RosType;

    RosMessage time = made_of("builtin_interfaces", "Time", {one(int32, "sec"), one(uint32, "nanosec")});
    RosMessage header = made_of("std_msgs", "Header", {one(time, "stamp"), one(text, "frame_id")});

    RosMessage vector3 = made_of("geometry_msgs", "Vector3", {one(float64, "x"), one(float64, "y"), one(float64, "z")});
    RosMessage point = made_of("geometry_msgs", "Point", {one(float64, "x"), one(float64, "y"), one(float64, "z")});
    RosMessage quaternion = made_of("geometry_msgs", "Quaternion",
                                    {one(float64, "x"), one(float64, "y"), one(float64, "z"), one(float64, "w")});
    RosMessage vector3_stamped = made_of("geometry_msgs", "Vector3Stamped", {one(header, "header"), one(vector3, "vector")});
    RosMessage point_stamped = made_of("geometry_msgs", "PointStamped", {one(header, "header"), one(point, "point")});
    RosMessage quaternion_stamped = made_of("geometry_msgs", "QuaternionStamped",
                                            {one(header, "header"), one(quaternion, "quaternion")});
    RosMessage pose = made_of("geometry_msgs", "Pose", {one(point, "position"), one(quaternion, "orientation")});
    RosMessage twist = made_of("geometry_msgs", "Twist", {one(vector3, "linear"), one(vector3, "angular")});
    RosMessage pose_with_covariance = made_of("geometry_msgs", "PoseWithCovariance",
                                              {one(pose, "pose"), numbers(float64, "covariance", 36)});
    RosMessage twist_with_covariance = made_of("geometry_msgs", "TwistWithCovariance",
                                               {one(twist, "twist"), numbers(float64, "covariance", 36)});
    RosMessage odometry = made_of("nav_msgs", "Odometry",
                                  {one(header, "header"), one(text, "child_frame_id"), one(pose_with_covariance, "pose"),
                                   one(twist_with_covariance, "twist")});

    RosMessage imu = made_of(
        "sensor_msgs", "Imu",
        {one(header, "header"), one(quaternion, "orientation"), numbers(float64, "orientation_covariance", 9),
         one(vector3, "angular_velocity"), numbers(float64, "angular_velocity_covariance", 9),
         one(vector3, "linear_acceleration"), numbers(float64, "linear_acceleration_covariance", 9)});
    RosMessage magnetic_field = made_of(
        "sensor_msgs", "MagneticField",
        {one(header, "header"), one(vector3, "magnetic_field"), numbers(float64, "magnetic_field_covariance", 9)});
    RosMessage temperature = made_of("sensor_msgs", "Temperature",
                                     {one(header, "header"), one(float64, "temperature"), one(float64, "variance")});
    RosMessage nav_sat_status = made_of(
        "sensor_msgs", "NavSatStatus",
        {one(int8, "status",
             {{"STATUS_UNKNOWN", -2}, {"STATUS_NO_FIX", -1}, {"STATUS_FIX", 0}, {"STATUS_SBAS_FIX", 1}, {"STATUS_GBAS_FIX", 2}}),
         one(uint16, "service",
             {{"SERVICE_UNKNOWN", 0},
              {"SERVICE_GPS", 1},
              {"SERVICE_GLONASS", 2},
              {"SERVICE_COMPASS", 4},
              {"SERVICE_GALILEO", 8}})});
    RosMessage nav_sat_fix = made_of(
        "sensor_msgs", "NavSatFix",
        {one(header, "header"), one(nav_sat_status, "status"), one(float64, "latitude"), one(float64, "longitude"),
         one(float64, "altitude"), numbers(float64, "position_covariance", 9),
         one(uint8, "position_covariance_type",
             {{"COVARIANCE_TYPE_UNKNOWN", 0},
              {"COVARIANCE_TYPE_APPROXIMATED", 1},
              {"COVARIANCE_TYPE_DIAGONAL_KNOWN", 2},
              {"COVARIANCE_TYPE_KNOWN", 3}})});
    RosMessage range = made_of(
        "sensor_msgs", "Range",
        {one(header, "header"), one(uint8, "radiation_type", {{"ULTRASOUND", 0}, {"INFRARED", 1}}), one(float32, "field_of_view"),
         one(float32, "min_range"), one(float32, "max_range"), one(float32, "range"), one(float32, "variance")});
    RosMessage point_field = made_of("sensor_msgs", "PointField",
                                     {one(text, "name"), one(uint32, "offset"),
                                      one(uint8, "datatype",
                                          {{"INT8", 1},
                                           {"UINT8", 2},
                                           {"INT16", 3},
                                           {"UINT16", 4},
                                           {"INT32", 5},
                                           {"UINT32", 6},
                                           {"FLOAT32", 7},
                                           {"FLOAT64", 8}}),
                                      one(uint32, "count")});
    RosMessage point_cloud = made_of("sensor_msgs", "PointCloud2",
                                     {one(header, "header"), one(uint32, "height"), one(uint32, "width"),
                                      list_of(point_field, "fields"), one(boolean, "is_bigendian"), one(uint32, "point_step"),
                                      one(uint32, "row_step"), sequence(uint8, "data"), one(boolean, "is_dense")});
    RosMessage image = made_of("sensor_msgs", "Image",
                               {one(header, "header"), one(uint32, "height"), one(uint32, "width"), one(text, "encoding"),
                                one(uint8, "is_bigendian"), one(uint32, "step"), sequence(uint8, "data")});
    RosMessage joy = made_of("sensor_msgs", "Joy",
                             {one(header, "header"), sequence(float32, "axes"), sequence(int32, "buttons")});
    RosMessage string = made_of("std_msgs", "String", {one(text, "data")});
    RosMessage log = made_of("rcl_interfaces", "Log",
                             {one(time, "stamp"), one(uint8, "level"), one(text, "name"), one(text, "msg"), one(text, "file"),
                              one(text, "function"), one(uint32, "line")});
    RosMessage key_value = made_of("diagnostic_msgs", "KeyValue", {one(text, "key"), one(text, "value")});
    RosMessage diagnostic_status = made_of(
        "diagnostic_msgs", "DiagnosticStatus",
        {one(byte, "level"), one(text, "name"), one(text, "message"), one(text, "hardware_id"), list_of(key_value, "values")});
    RosMessage diagnostic_array = made_of("diagnostic_msgs", "DiagnosticArray",
                                          {one(header, "header"), list_of(diagnostic_status, "status")});
    RosMessage transform = made_of("geometry_msgs", "Transform", {one(vector3, "translation"), one(quaternion, "rotation")});
    RosMessage transform_stamped = made_of("geometry_msgs", "TransformStamped",
                                           {one(header, "header"), one(text, "child_frame_id"), one(transform, "transform")});
    RosMessage tf_message = made_of("tf2_msgs", "TFMessage", {list_of(transform_stamped, "transforms")});
    RosMessage battery_state = made_of("sensor_msgs", "BatteryState", battery_fields());

    std::vector<RosField> battery_fields() const {
        std::vector<RosField> fields{one(header, "header")};
        for (const char* name : {"voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage"})
            fields.push_back(one(float32, name));
        const auto add = [&](const char* name, const std::string& prefix, std::initializer_list<const char*> values) {
            fields.push_back(one(uint8, name));
            for (const char* value : values)
                fields.back().constants.push_back({prefix + value, static_cast<std::int64_t>(fields.back().constants.size())});
        };
        add("power_supply_status", "POWER_SUPPLY_STATUS_", {"UNKNOWN", "CHARGING", "DISCHARGING", "NOT_CHARGING", "FULL"});
        add("power_supply_health", "POWER_SUPPLY_HEALTH_",
            {"UNKNOWN", "GOOD", "OVERHEAT", "DEAD", "OVERVOLTAGE", "UNSPEC_FAILURE", "COLD", "WATCHDOG_TIMER_EXPIRE",
             "SAFETY_TIMER_EXPIRE"});
        add("power_supply_technology", "POWER_SUPPLY_TECHNOLOGY_",
            {"UNKNOWN", "NIMH", "LION", "LIPO", "LIFE", "NICD", "LIMN", "TERNARY", "VRLA"});
        fields.push_back(one(boolean, "present"));
        fields.push_back(sequence(float32, "cell_voltage"));
        fields.push_back(sequence(float32, "cell_temperature"));
        fields.push_back(one(text, "location"));
        fields.push_back(one(text, "serial_number"));
        return fields;
    }
};

}    // namespace

const StandardTypes& standard_types() {
    static const Definitions d;
    static const StandardTypes types{
        .imu = &d.imu,
        .magnetic_field = &d.magnetic_field,
        .temperature = &d.temperature,
        .nav_sat_fix = &d.nav_sat_fix,
        .battery_state = &d.battery_state,
        .range = &d.range,
        .quaternion_stamped = &d.quaternion_stamped,
        .vector3_stamped = &d.vector3_stamped,
        .point_stamped = &d.point_stamped,
        .odometry = &d.odometry,
        .point_cloud = &d.point_cloud,
        .image = &d.image,
        .joy = &d.joy,
        .twist = &d.twist,
        .string = &d.string,
        .log = &d.log,
        .diagnostic_array = &d.diagnostic_array,
        .tf_message = &d.tf_message,
    };
    return types;
}

}    // namespace anogate
