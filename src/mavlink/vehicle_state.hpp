// The latest values of a device, in the units and frames of reference of MAVLink: SI; axes of the vehicle forward, right, down (FRD); of
// the ground north, east, down (NED). No I/O, no clock.
//
// Devices send axes of the vehicle forward, left, up, and of the ground north, west, up (src/ros/README.md states what is assumed).
#pragma once
#include <ano/attitude.hpp>
#include <ano/reading.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace anogate::mavlink {

inline constexpr double metres_per_degree = 111'194.9;    // of latitude, on a sphere of 6371 km

struct Vector {
    double x = 0, y = 0, z = 0;
};

/// Roll, pitch and yaw in radians: roll to the right, pitch nose up, yaw clockwise from north.
struct Angles {
    double roll = 0, pitch = 0, yaw = 0;
};
Angles angles_of(const ano::Rotation& ned_of_frd) noexcept;
/// From the axes of devices to those of MAVLink.
constexpr ano::Rotation ned_of_frd(const ano::Rotation& device) noexcept { return {device.w, device.x, -device.y, -device.z}; }

/// A value and the time of its frame.
template <class T>
class Latest {
public:
    /// A value is valid for this time.
    static constexpr ano::Duration validity = std::chrono::seconds{2};

    void set(const T& value, ano::TimePoint now) noexcept {
        value_ = value;
        at_ = now;
    }
    /// nullptr: nothing was received, or it is too old.
    const T* at(ano::TimePoint now) const noexcept { return value_ && now - at_ <= validity ? &*value_ : nullptr; }
    /// However old.
    const T* last() const noexcept { return value_ ? &*value_ : nullptr; }

private:
    std::optional<T> value_;
    ano::TimePoint at_{};
};

using Cid = std::array<std::uint8_t, 3>;

/// 0x06.
struct FlightMode {
    enum class Safety : std::uint8_t { locked, unlocked, airborne };
    std::uint8_t mode = 0;
    Safety safety = Safety::locked;
    Cid command{};    // that is being executed
    bool is_armed() const noexcept { return safety != Safety::locked; }
};

struct Fix {
    std::uint8_t fix = 0;    // as UBX: 2 2D, 3 3D, 4 3D with dead reckoning
    std::uint8_t satellites = 0;
    std::int32_t lat = 0, lng = 0;                     // 1e-7 degrees
    double altitude = 0;                               // m, by the receiver's reference
    Vector velocity;                                   // m/s
    double dilution = 0;                               // of precision
    double speed_accuracy = 0, height_accuracy = 0;    // m/s, m
    bool is_valid() const noexcept { return fix >= 2 && fix <= 4; }
};

struct Altitudes {
    double barometric = std::numeric_limits<double>::quiet_NaN(), additional = 0, fused = 0;    // m
};

struct Power {
    double voltage = 0, current = 0;    // V, A
};

struct Modules {
    std::uint8_t velocity = 0, position = 0, gps = 0, altitude = 0;    // 0 no data, 1 unusable, 2 normal, 3 good
};

struct WayHome {
    double bearing = 0;     // degrees clockwise from north
    double distance = 0;    // m
};

struct Outputs {
    std::array<double, 8> percent{};
    std::size_t count = 0;
};

struct Flow {
    std::uint8_t quality = 0;
    double pixels_x = 0, pixels_y = 0;    // per message
    Vector speed;                         // over ground, m/s
};

struct Home {
    std::int32_t lat = 0, lng = 0;    // 1e-7 degrees
    double altitude = 0;              // m
};

/// Directions of 0x34.
enum class Side : std::uint8_t { down, forward, back, left, right, up };
inline constexpr std::size_t sides = 6, scan_sectors = 72;

class VehicleState {
public:
    static constexpr std::uint16_t nothing_measured = 0xFFFF;    // a sector of a scan

    explicit VehicleState(ano::EulerSigns signs = ano::EulerSigns::document) noexcept : signs_{signs} {}
    void set_signs(ano::EulerSigns signs) noexcept { signs_ = signs; }

    /// The number of frames of this message that were received.
    std::uint32_t frames(std::uint8_t id) const noexcept { return frames_[id]; }
    /// A frame of the device.
    void receive(const ano::Reading& reading, ano::TimePoint now) noexcept;

    /// By a quaternion (0x04), or by Euler angles (0x03) if the device sends no quaternions: one orientation for all messages.
    const ano::Rotation* attitude(ano::TimePoint now) const noexcept {
        const ano::Rotation* const best = by_quaternion_.at(now);
        return best != nullptr ? best : by_euler_.at(now);
    }
    /// Where position() is 0. It is kept from unlocking to the next unlocking.
    const std::optional<Home>& home() const noexcept { return home_; }

    Latest<FlightMode> mode;
    Latest<Vector> rates;             // rad/s
    Latest<Vector> acceleration;      // m/s²; at rest -9.8 along z
    Latest<Vector> magnetic_field;    // milligauss
    Latest<double> temperature;       // °C
    Latest<Vector> velocity;          // m/s
    Latest<Vector> position;          // m, from the take-off point
    Latest<double> height;            // m, above the take-off point
    Latest<Vector> wind;              // m/s, of the air
    Latest<Angles> target_attitude;
    Latest<Vector> target_velocity;
    Latest<Altitudes> altitudes;
    Latest<Fix> fix;
    Latest<Power> power;
    Latest<Modules> modules;
    Latest<WayHome> way_home;
    Latest<Outputs> outputs;
    Latest<double> throttle;                                 // %
    Latest<std::array<std::uint16_t, 10>> sticks;            // roll, pitch, throttle, yaw, aux1 to aux6
    std::array<Latest<double>, sides> distances;             // m
    Latest<std::array<std::uint16_t, scan_sectors>> scan;    // cm, clockwise from the nose
    Latest<Flow> flow;

private:
    double number(std::string_view field) const noexcept;
    Vector of_vehicle(const char* x, const char* y, const char* z, double factor) const noexcept;
    void on_attitude(ano::TimePoint now) noexcept;
    void on_mode(ano::TimePoint now) noexcept;
    void on_fix(ano::TimePoint now) noexcept;
    void on_position(ano::TimePoint now) noexcept;
    void on_outputs(ano::TimePoint now) noexcept;
    void on_ranging(ano::TimePoint now) noexcept;
    void on_flow(ano::TimePoint now) noexcept;
    void on_sticks(ano::TimePoint now) noexcept;
    void find_home(ano::TimePoint now) noexcept;

    ano::EulerSigns signs_;
    const ano::Reading* reading_ = nullptr;    // during receive()
    Latest<ano::Rotation> by_quaternion_, by_euler_;
    std::optional<Home> home_;
    bool home_is_fixed_ = false;
    std::array<std::uint32_t, 256> frames_{};    // by message
};

}    // namespace anogate::mavlink
