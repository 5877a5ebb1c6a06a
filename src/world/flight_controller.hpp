// sim:fc. A flight controller; commands, waypoints, 0x40 and 0x41 control it.
#pragma once
#include "flight.hpp"
#include "inertial_unit.hpp"
#include "satellites.hpp"
#include "simulated_device.hpp"
#include "test_picture.hpp"

#include <array>
#include <string>
#include <vector>

namespace ano::world {

/// The command (0xC0) that starts the task; 0x06 reports it while the task runs.
constexpr device::CommandId command_of(Flight::Task task) noexcept {
    constexpr std::array<std::uint8_t, 7> numbers{4, 1, 2, 8, 9, 10, 12};
    return {0x10, 0, numbers[static_cast<std::size_t>(task)]};
}

class FlightController final : public SimulatedDevice {
public:
    static constexpr std::size_t parameter_count = 150;

    FlightController(const Settings& settings, TimePoint start);

    const Flight& flight() const noexcept { return flight_; }

private:
    struct Other {    // parameters without effect
        std::uint64_t serial = 0xA0'0000'0001;
        std::int64_t born = 0;
        std::string note = "simulated";
        std::vector<device::Value> user;
    };

    void advance() override { flight_.step(dt, chance()); }
    void heard(FrameView frame) override;
    bool may_be_upgraded() const override { return flight_.safety() == Flight::Safety::locked; }

    void add_parameters();
    void add_own_parameters();
    void add_user_parameters();
    void add_commands();
    void add_flights();
    void add_waypoints();
    bool fly_waypoints(std::uint8_t first);
    Vector place_of(const device::Waypoint& waypoint) const noexcept;
    RoutePoint route_point(const device::Waypoint& waypoint) const noexcept;

    void add_streams();
    void altitude();
    void movement();
    void position();
    void satellites();
    void targets();
    void mode();
    void outputs();
    void surroundings();
    void health();
    void flexible();

    FlightSettings settings_;
    Flight flight_;
    InertialUnit inertial_;
    Satellites satellites_;
    TestPicture picture_;
    std::int16_t barometer_offset_ = 15;
    std::int32_t range_offset_ = 0;
    std::uint8_t pictures_ = 1;    // per second
    Place home_{116.3, 39.9};
    Other other_;
};

}    // namespace ano::world
