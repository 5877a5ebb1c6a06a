// Converts the messages of a device to standard ROS 2 messages: metres, radians, tesla, and the axes of REP 103. For the mapping and its
// assumptions see README.md.
//
// Flow:    StandardMessages device{"fc/device_220"};
//          for (const StandardTopic topic : device.hear(reading, time_ns)) {
//              values.clear();
//              device.append_values(topic, values);                     // of standard_row(topic).type
//          }
#pragma once
#include <ano/attitude.hpp>
#include <ano/reading.hpp>
#include <ros/image_rows.hpp>
#include <ros/ros_message.hpp>
#include <ros/value_list.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

enum class StandardTopic : std::uint8_t {
    imu,
    magnetic_field,
    temperature,
    orientation,
    linear_velocity,
    point,
    odometry,
    battery,
    fix,
    fix_velocity,
    external_point,
    external_velocity,
    scan,
    image_raw,
    range_down,    // from here on in the order of `type` of ranging (0x34); 6 is down as well
    range_forward,
    range_back,
    range_left,
    range_right,
    range_up,
};
inline constexpr std::size_t standard_topics = 20;

struct StandardRow {
    std::string_view name;    // of its topic; different from all names in the message table
    const RosMessage* type;
};
const StandardRow& standard_row(StandardTopic topic);

/// Variances of measurements, in the square of the unit of the message; 0: unknown.
struct Variances {
    double orientation = 0;            // rad², of each axis, as the next four
    double angular_velocity = 0;       // (rad/s)²
    double linear_acceleration = 0;    // (m/s²)²
    double position = 0;               // m², of `odometry`
    double velocity = 0;               // (m/s)², of `odometry`
    double magnetic_field = 0;         // T²
    double temperature = 0;            // °C²
    double range = 0;                  // m²
    double fix = 0;                    // m², horizontal; known only together with the next one
    double fix_altitude = 0;           // m²
};

/// As in sensor_msgs: all zeros mean an unknown covariance, -1 in the first element that the value is missing.
template <std::size_t Size>
struct Covariance {
    std::array<std::uint8_t, Size * sizeof(double)> bytes{};
    constexpr void set(std::size_t i, double value) noexcept { ano::store(bytes.data() + i * sizeof value, value); }
};

/// The messages of one device on one link.
class StandardMessages {
public:
    /// Older values are not combined with new ones.
    static constexpr std::uint64_t fresh_ns = 1'000'000'000;

    /// `frame`: frame_id of the device in headers. `images` collects the rows of all devices and must outlive this object;
    /// `sender` identifies this device there. nullptr: no images.
    explicit StandardMessages(std::string_view frame, ImageRows* images = nullptr, std::uint64_t sender = 0);

    /// Returns the topics with a message from this frame of the device. Valid until the next call; append_values() may be called
    /// as long as the frame is valid.
    std::span<const StandardTopic> receive(const ano::Reading& reading, std::uint64_t time_ns);
    /// `topic`: one of those returned by hear(). Texts in `out` refer to this object.
    void append_values(StandardTopic topic, ValueList& out) const;

    struct Vector {
        double x = 0, y = 0, z = 0;
    };
    using Rotation = ano::Rotation;

    /// The signs of its Euler angles, from the next frame on.
    void set_attitude(ano::EulerSigns signs) noexcept { signs_ = signs; }

    /// Of all following messages; unknown before.
    void set_variances(const Variances& variances) noexcept;

private:
    template <class T>
    struct Heard {
        T value{};
        std::optional<std::uint64_t> time_ns;
    };
    template <class T>
    bool is_fresh(const Heard<T>& heard) const noexcept;
    void publish(StandardTopic topic) noexcept { published_[published_count_++] = topic; }
    double number(std::string_view field) const noexcept;
    Vector vector(std::string_view prefix, double factor) const noexcept;

    void on_euler();
    void on_quaternion();
    void on_position();
    void on_gps();
    void on_ranging();

    void append_header(std::string_view frame, ValueList& out) const;
    void append_imu(ValueList& out) const;
    void append_odometry(ValueList& out) const;
    void append_battery(ValueList& out) const;
    void append_fix(ValueList& out) const;
    void append_scan(ValueList& out) const;
    void append_image(ValueList& out) const;
    void append_range(StandardTopic topic, ValueList& out) const;

    std::string frame_, ground_, east_north_up_, external_, camera_;
    std::array<std::string, 6> range_frames_;

    ano::EulerSigns signs_{};
    Variances variances_;
    Covariance<9> orientation_covariance_{}, rates_covariance_{}, acceleration_covariance_{}, field_covariance_{},
        fix_covariance_{};
    Covariance<36> pose_covariance_{}, twist_covariance_{}, twist_without_rates_{};
    Heard<Rotation> by_quaternion_, by_euler_;
    Heard<Vector> velocity_, rates_;

    ImageRows* images_;
    std::uint64_t sender_;
    const WholeImage* image_ = nullptr;    // completed by the last frame

    std::optional<ano::Reading> reading_;    // the last frame
    std::uint64_t now_ns_ = 0;
    std::array<StandardTopic, 2> published_{};
    std::size_t published_count_ = 0;
};

}    // namespace anogate
