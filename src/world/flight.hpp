// The flight of the simulated flight controller: its tasks, and how they are carried out. Metres, seconds, radians.
#pragma once
#include "battery.hpp"
#include "body.hpp"
#include "hand.hpp"
#include "pilot.hpp"
#include "weather.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

namespace ano::world {

/// Settings from parameters that hosts can change. See the `info` of the parameters.
struct FlightSettings {
    std::uint8_t mode = 2;
    std::int8_t turn = 0;          // °/s, in hover
    std::uint16_t height = 120;    // cm
    std::uint16_t speed = 300;     // cm/s
    std::uint32_t flight_time = 900;
    float wind = 1;                   // m/s
    float sway = 20;                  // gusts, % of the wind
    std::uint16_t wind_from = 270;    // °
    Gains gains;
};

/// The sticks of 0x40: -1 to 1 each, the throttle 0 to 1.
struct Sticks {
    double roll = 0, pitch = 0, throttle = 0, yaw = 0;
    bool centred() const noexcept;
};

/// 0x41.
struct Steering {
    Angles lean;
    double throttle = 0, yaw_rate = 0;
    Vector velocity;    // forward, left, up
};

/// One point of a route.
struct RoutePoint {
    Vector there;                   // from home
    double speed = 0;               // m/s; 0: FlightSettings::speed
    std::optional<double> yaw{};    // to the left of north; std::nullopt: towards the point
    double stay = 0;                // s, at the point
};

class Flight {
public:
    enum class Mode : std::uint8_t { attitude, height, position, programmed };
    enum class Task : std::uint8_t { hover, take_off, land, go_to, yaw, return_home, route };
    enum class Safety : std::uint8_t { locked, unlocked, airborne };
    static constexpr double min_height = 0.2, max_height = 100, max_distance = 1000;    // m
    static constexpr double low_battery = 0.2, last_battery = 0.1;
    static constexpr double input_lasts = 1;    // s, validity of an input of the sticks

    /// `report` sends a log line to the hosts; `is_bad`: a warning.
    explicit Flight(const FlightSettings& settings, std::function<void(std::string_view, bool is_bad)> report)
        : settings_{settings}, report_{std::move(report)} {}

    // Each returns false if the task is not possible now.
    bool unlock();
    bool lock();
    /// Emergency stop: the motors stop at once, also in the air.
    void stop();
    bool take_off(double height);
    bool land();
    bool hover();
    bool go_to(Vector there);
    bool yaw(double yaw);
    bool return_home();
    bool fly(std::vector<RoutePoint> route);
    /// Whether it may be turned by hand for a calibration: it is on the ground and locked.
    bool may_be_turned() const noexcept { return safety() == Safety::locked; }

    void receive(const Sticks& sticks) noexcept;
    void expire_sticks() noexcept { sticks_age_ = input_lasts; }
    void receive(const Steering& steering) noexcept;

    void step(double dt, Noise& chance);

    Safety safety() const noexcept;
    Task task() const noexcept { return task_; }
    const Body& body() const noexcept { return body_; }
    const Pilot& pilot() const noexcept { return pilot_; }
    Battery& battery() noexcept { return battery_; }
    const Battery& battery() const noexcept { return battery_; }
    Vector wind() const noexcept { return weather_.wind(); }
    Hand& hand() noexcept { return hand_; }
    /// The position relative to the last take-off.
    Vector offset() const noexcept { return body_.position() - from_; }

private:
    Motors motors(double dt);
    Motors by_hand(double dt);
    Motors by_task(double dt);
    Motors at_its_place(double dt);
    Motors on_route(double dt);
    bool faces(const RoutePoint& point, double dt) noexcept;
    Motors leaning(Angles lean, double throttle, double climb, double dt);
    Motors at_velocity(Vector of_the_nose, double dt);
    bool begin(Task task);
    void end();
    void look_after_the_battery();
    void left_the_ground();
    void landed();
    bool has_sticks() const noexcept { return sticks_age_ < input_lasts; }
    bool is_steered() const noexcept { return steering_age_ < input_lasts; }
    bool may_climb(double climb) const noexcept { return !body_.on_ground() || climb > 0.1; }

    const FlightSettings& settings_;
    std::function<void(std::string_view, bool)> report_;
    Body body_;
    Pilot pilot_;
    Battery battery_;
    Weather weather_;
    Hand hand_;
    bool is_locked_ = true;
    bool was_low_ = false;
    bool flies_ = false;
    Task task_ = Task::hover;
    Vector from_, place_;
    double aimed_yaw_ = 0;
    std::vector<RoutePoint> route_;
    std::size_t next_ = 0;
    double stayed_ = 0;    // s, at the next point
    Sticks sticks_;
    Steering steering_;
    double sticks_age_ = input_lasts, steering_age_ = input_lasts;
};

}    // namespace ano::world
