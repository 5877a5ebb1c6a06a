// The values of a message in the order of its fields, as text: for programs with the types of a code generator. The includer defines
// MESSAGE(package, Name), the type of a message, and FIELD(name), a field of the message `m`.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

class Values {
public:
    void add(double value) { append(std::isfinite(value) ? format("%.17g", value) : "null"); }
    void add(float value) { append(std::isfinite(value) ? format("%.9g", static_cast<double>(value)) : "null"); }
    void add(bool value) { append(value ? "true" : "false"); }
    void add(const char* text) {
        std::string quoted = "\"";
        for (const char* at = text; *at != 0; ++at) {
            constexpr char first_visible = ' ';
            char code[8];
            if (*at == '"' || *at == '\\') quoted += '\\';
            if (*at > 0 && *at < first_visible) std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(*at));
            if (*at > 0 && *at < first_visible) quoted += code;
            else quoted += *at;
        }
        append(quoted + '"');
    }
    void add(const std::string& text) { add(text.c_str()); }
    void add(std::uint8_t value) { append(std::to_string(value)); }
    void add(std::int8_t value) { append(std::to_string(value)); }
    void add(std::uint16_t value) { append(std::to_string(value)); }
    void add(std::int32_t value) { append(std::to_string(value)); }
    void add(std::uint32_t value) { append(std::to_string(value)); }
    template <class T, std::size_t Size>
    void add(const T (&array)[Size]) {
        for (const T& value : array) add(value);
    }
    template <class T, std::size_t Size>
    void add(const std::array<T, Size>& array) {
        for (const T& value : array) add(value);
    }
    template <class T>
    void add(const std::vector<T>& list) {
        for (const T& value : list) add(value);
    }
    template <class Sequence>
    auto add(const Sequence& list) -> decltype(list._buffer, void()) {
        for (std::uint32_t i = 0; i < list._length; ++i) add(list._buffer[i]);
    }
    template <class... Parts>
    void all(const Parts&... parts) {
        (add(parts), ...);
    }

    void add(const MESSAGE(builtin_interfaces, Time) & m) { all(FIELD(sec), FIELD(nanosec)); }
    void add(const MESSAGE(std_msgs, Header) & m) { all(FIELD(stamp), FIELD(frame_id)); }
    void add(const MESSAGE(std_msgs, String) & m) { all(FIELD(data)); }
    void add(const MESSAGE(geometry_msgs, Vector3) & m) { all(FIELD(x), FIELD(y), FIELD(z)); }
    void add(const MESSAGE(geometry_msgs, Point) & m) { all(FIELD(x), FIELD(y), FIELD(z)); }
    void add(const MESSAGE(geometry_msgs, Quaternion) & m) { all(FIELD(x), FIELD(y), FIELD(z), FIELD(w)); }
    void add(const MESSAGE(geometry_msgs, Vector3Stamped) & m) { all(FIELD(header), FIELD(vector)); }
    void add(const MESSAGE(geometry_msgs, PointStamped) & m) { all(FIELD(header), FIELD(point)); }
    void add(const MESSAGE(geometry_msgs, QuaternionStamped) & m) { all(FIELD(header), FIELD(quaternion)); }
    void add(const MESSAGE(geometry_msgs, Pose) & m) { all(FIELD(position), FIELD(orientation)); }
    void add(const MESSAGE(geometry_msgs, Twist) & m) { all(FIELD(linear), FIELD(angular)); }
    void add(const MESSAGE(geometry_msgs, PoseWithCovariance) & m) { all(FIELD(pose), FIELD(covariance)); }
    void add(const MESSAGE(geometry_msgs, TwistWithCovariance) & m) { all(FIELD(twist), FIELD(covariance)); }
    void add(const MESSAGE(geometry_msgs, Transform) & m) { all(FIELD(translation), FIELD(rotation)); }
    void add(const MESSAGE(geometry_msgs, TransformStamped) & m) { all(FIELD(header), FIELD(child_frame_id), FIELD(transform)); }
    void add(const MESSAGE(tf2_msgs, TFMessage) & m) { all(FIELD(transforms)); }
    void add(const MESSAGE(nav_msgs, Odometry) & m) { all(FIELD(header), FIELD(child_frame_id), FIELD(pose), FIELD(twist)); }
    void add(const MESSAGE(sensor_msgs, Imu) & m) {
        all(FIELD(header), FIELD(orientation), FIELD(orientation_covariance), FIELD(angular_velocity),
            FIELD(angular_velocity_covariance), FIELD(linear_acceleration), FIELD(linear_acceleration_covariance));
    }
    void add(const MESSAGE(sensor_msgs, MagneticField) & m) {
        all(FIELD(header), FIELD(magnetic_field), FIELD(magnetic_field_covariance));
    }
    void add(const MESSAGE(sensor_msgs, Temperature) & m) { all(FIELD(header), FIELD(temperature), FIELD(variance)); }
    void add(const MESSAGE(sensor_msgs, NavSatStatus) & m) { all(FIELD(status), FIELD(service)); }
    void add(const MESSAGE(sensor_msgs, NavSatFix) & m) {
        all(FIELD(header), FIELD(status), FIELD(latitude), FIELD(longitude), FIELD(altitude), FIELD(position_covariance),
            FIELD(position_covariance_type));
    }
    void add(const MESSAGE(sensor_msgs, Range) & m) {
        all(FIELD(header), FIELD(radiation_type), FIELD(field_of_view), FIELD(min_range), FIELD(max_range), FIELD(range),
            FIELD(variance));
    }
    void add(const MESSAGE(sensor_msgs, PointField) & m) { all(FIELD(name), FIELD(offset), FIELD(datatype), FIELD(count)); }
    void add(const MESSAGE(sensor_msgs, PointCloud2) & m) {
        all(FIELD(header), FIELD(height), FIELD(width), FIELD(fields), FIELD(is_bigendian), FIELD(point_step), FIELD(row_step),
            FIELD(data), FIELD(is_dense));
    }
    void add(const MESSAGE(sensor_msgs, Image) & m) {
        all(FIELD(header), FIELD(height), FIELD(width), FIELD(encoding), FIELD(is_bigendian), FIELD(step), FIELD(data));
    }
    void add(const MESSAGE(sensor_msgs, BatteryState) & m) {
        all(FIELD(header), FIELD(voltage), FIELD(temperature), FIELD(current), FIELD(charge), FIELD(capacity),
            FIELD(design_capacity), FIELD(percentage), FIELD(power_supply_status), FIELD(power_supply_health),
            FIELD(power_supply_technology), FIELD(present), FIELD(cell_voltage), FIELD(cell_temperature), FIELD(location),
            FIELD(serial_number));
    }
    void add(const MESSAGE(sensor_msgs, Joy) & m) { all(FIELD(header), FIELD(axes), FIELD(buttons)); }
    void add(const MESSAGE(rcl_interfaces, Log) & m) {
        all(FIELD(stamp), FIELD(level), FIELD(name), FIELD(msg), FIELD(file), FIELD(function), FIELD(line));
    }
    void add(const MESSAGE(diagnostic_msgs, KeyValue) & m) { all(FIELD(key), FIELD(value)); }
    void add(const MESSAGE(diagnostic_msgs, DiagnosticStatus) & m) {
        all(FIELD(level), FIELD(name), FIELD(message), FIELD(hardware_id), FIELD(values));
    }
    void add(const MESSAGE(diagnostic_msgs, DiagnosticArray) & m) { all(FIELD(header), FIELD(status)); }

    const std::string& text() const { return text_; }

private:
    static std::string format(const char* how, double value) {
        char buffer[40];
        std::snprintf(buffer, sizeof buffer, how, value);
        return buffer;
    }
    void append(const std::string& value) { text_ += (text_.empty() ? "" : ", ") + value; }

    std::string text_;
};

/// Calls X(package, Name) for each message that can be received.
#define EACH_MESSAGE(X)                 \
    X(sensor_msgs, Imu)                 \
    X(sensor_msgs, MagneticField)       \
    X(sensor_msgs, Temperature)         \
    X(geometry_msgs, QuaternionStamped) \
    X(geometry_msgs, Vector3Stamped)    \
    X(geometry_msgs, PointStamped)      \
    X(nav_msgs, Odometry)               \
    X(sensor_msgs, BatteryState)        \
    X(sensor_msgs, NavSatFix)           \
    X(sensor_msgs, Range)               \
    X(sensor_msgs, PointCloud2)         \
    X(sensor_msgs, Image)               \
    X(sensor_msgs, Joy)                 \
    X(std_msgs, String)                 \
    X(rcl_interfaces, Log)              \
    X(diagnostic_msgs, DiagnosticArray) \
    X(tf2_msgs, TFMessage)
