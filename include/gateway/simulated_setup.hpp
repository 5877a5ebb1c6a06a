// What hosts can set and command of the simulated flight controller.
#pragma once
#include <device/device.hpp>

#include <array>
#include <cstdint>
#include <string>

namespace anogate {

/// Parameters of all eleven types, commands with values of many, waypoints: each shows in what the flight controller sends, or comes back
/// when it is read.
class SimulatedSetup {
public:
    explicit SimulatedSetup(ano::device::Device& device);
    SimulatedSetup(const SimulatedSetup&) = delete;
    SimulatedSetup& operator=(const SimulatedSetup&) = delete;

    bool flies() const noexcept { return flies_; }
    double sway() const noexcept { return flies_ ? sway_ : 0; }               // °
    double height() const noexcept { return flies_ ? height_ : 0; }           // cm
    double turn() const noexcept { return flies_ ? turn_ : 0; }               // °/s
    double barometer_offset() const noexcept { return barometer_offset_; }    // cm
    double range_offset() const noexcept { return range_offset_; }            // cm, of the additional height sensor
    double flight_time() const noexcept { return flight_time_; }              // s
    std::uint8_t mode() const noexcept { return mode_; }
    /// An acceleration as its calibration corrects it: error matrix · sensitivity · (raw − offset).
    std::array<double, 3> corrected(std::array<double, 3> raw) const noexcept;

private:
    void add_parameters();
    void add_commands();

    ano::device::Device& device_;
    bool flies_ = true;
    std::uint8_t mode_ = 3;    // position hold
    std::int8_t turn_ = 6;
    std::uint16_t height_ = 120;
    std::int16_t barometer_offset_ = 15;
    std::uint32_t flight_time_ = 900;
    std::int32_t range_offset_ = 0;
    std::int64_t born_ = 0;
    float sway_ = 4;
    double home_lng_ = 116.3, home_lat_ = 39.9;
    std::string note_ = "simulated";
    std::array<float, 15> accelerometer_{};
    std::array<float, 6> compass_{};
};

}    // namespace anogate
