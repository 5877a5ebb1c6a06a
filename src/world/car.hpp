// sim:car. A car that 0x40, 0x41 and its commands steer.
#pragma once
#include "battery.hpp"
#include "inertial_unit.hpp"
#include "simulated_device.hpp"

#include <optional>

namespace ano::world {

class Car final : public SimulatedDevice {
public:
    static constexpr std::uint8_t usual_id = 40;
    static constexpr double input_lasts = 1;    // s, validity of an input of the sticks

    Car(const Settings& settings, TimePoint start);

    Vector position() const noexcept { return position_; }
    double speed() const noexcept { return speed_; }
    double yaw() const noexcept { return yaw_; }
    bool is_locked() const noexcept { return is_locked_; }

private:
    struct Aim {
        double speed = 0, yaw_rate = 0;
    };

    void advance() override;
    void heard(FrameView frame) override;
    bool may_be_upgraded() const override { return is_locked_; }

    Aim aim() noexcept;
    Aim towards(Vector there) noexcept;
    void add_commands();
    void add_streams();
    void movement();
    void surroundings();
    void health();

    std::uint16_t top_speed_ = 300;        // cm/s
    std::uint16_t acceleration_ = 200;     // cm/s²
    std::uint8_t turn_ = 90;               // °/s
    std::uint32_t driving_time_ = 3600;    // s
    InertialUnit inertial_;
    Battery battery_;
    Hand hand_;
    Attitude held_;
    bool is_locked_ = true;
    Vector position_;
    double speed_ = 0, yaw_ = 0, yaw_rate_ = 0, gain_ = 0;
    Aim steered_;
    double steered_age_ = input_lasts;
    std::optional<Vector> there_;    // the target of a command
};

}    // namespace ano::world
