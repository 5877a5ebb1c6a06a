// What a device says as standard messages of ROS 2: metres, radians, tesla, and the axes of REP 103. What stands for what, and what is
// taken for granted: README.md.
//
// Flow:    StandardMessages device{"fc/device_220"};
//          for (const StandardTopic topic : device.hear(reading, time_ns)) {
//              values.clear();
//              device.append_values(topic, values);                     // of standard_row(topic).type
//          }
#pragma once
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
    range_down,    // from here in the order of the `type` of ranging (0x34); 6 is down as well
    range_forward,
    range_back,
    range_left,
    range_right,
    range_up,
};
inline constexpr std::size_t standard_topics = 20;

struct StandardRow {
    std::string_view name;    // of its topic; no message of the table is called so
    const RosMessage* type;
};
const StandardRow& standard_row(StandardTopic topic);

/// Of one device on one link.
class StandardMessages {
public:
    /// What is older than this is not put beside what is new.
    static constexpr std::uint64_t fresh_ns = 1'000'000'000;

    /// `frame` names the device in headers. `images`, which outlives it, has the rows of all devices, of which this one has the number
    /// `sender`; nullptr: there are no images.
    explicit StandardMessages(std::string_view frame, ImageRows* images = nullptr, std::uint64_t sender = 0);

    /// The messages that this frame of the device makes. Valid until the next call, and append_values() as long as the frame.
    std::span<const StandardTopic> hear(const ano::Reading& reading, std::uint64_t time_ns);
    /// `topic` is one of those. The texts in `out` are the device's.
    void append_values(StandardTopic topic, ValueList& out) const;

    struct Vector {
        double x = 0, y = 0, z = 0;
    };
    /// Turns what is said in the device's axes into the ground's.
    struct Rotation {
        double w = 1, x = 0, y = 0, z = 0;
    };

private:
    template <class T>
    struct Heard {
        T value{};
        std::optional<std::uint64_t> time_ns;
    };
    template <class T>
    bool is_fresh(const Heard<T>& heard) const noexcept;
    void tell(StandardTopic topic) noexcept { told_[told_count_++] = topic; }
    double number(std::string_view field) const noexcept;
    Vector vector(std::string_view prefix, double factor) const noexcept;

    void hear_euler();
    void hear_quaternion();
    void hear_position();
    void hear_gps();
    void hear_ranging();

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

    Heard<Rotation> by_quaternion_, by_euler_;
    Heard<Vector> velocity_, rates_;

    ImageRows* images_;
    std::uint64_t sender_;
    const WholeImage* image_ = nullptr;    // that the last frame ended

    std::optional<ano::Reading> reading_;    // of the last frame
    std::uint64_t now_ns_ = 0;
    std::array<StandardTopic, 2> told_{};
    std::size_t told_count_ = 0;
};

}    // namespace anogate
