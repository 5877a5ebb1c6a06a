#include "car.hpp"
#include "room.hpp"
#include "say_attitude.hpp"

namespace ano::world {

Car::Car(const Settings& settings, TimePoint start)
    : SimulatedDevice{{.id = settings.id != 0 ? settings.id : usual_id, .name = "SimCar"}, settings, start}, inertial_{chance()} {
    auto& parameters = device().parameters();
    parameters.add("SIM_TOP_SPEED", top_speed_, {.info = "cm/s", .min = 10, .max = 2000});
    parameters.add("SIM_ACCELERATION", acceleration_, {.info = "cm/s²", .min = 10, .max = 1000});
    parameters.add("SIM_TURN", turn_, {.info = "maximum turn rate, degrees per second", .min = 5, .max = 180});
    parameters.add("SIM_DRIVING_TIME", driving_time_,
                   {.info = "driving time until the battery is empty, s", .min = 60, .max = 86'400});
    inertial_.add_calibrations(parameters, hand_, hz(), {[this] { return is_locked_; }, [this] { return store_values(); }});
    parameters.on_save([this] { return store_values(); });
    add_commands();
    add_streams();
}

void Car::add_commands() {
    auto& commands = device().commands();
    commands.add({0x20, 0, 1}, "UNLOCK", "", [this] {
        if (hand_.holds() || battery_.charge() <= 0) return false;
        is_locked_ = false;
        return true;
    });
    commands.add({0x20, 0, 2}, "LOCK", "stops at once", [this] {
        is_locked_ = true;
        there_.reset();
    });
    commands.add({0x20, 0, 3}, "STOP", "", [this] { there_.reset(); });
    commands.add({0x20, 0, 4}, "GO_TO", "cm from the start point: north, west", [this](std::int32_t x, std::int32_t y) {
        const Vector there{x / 100.0, y / 100.0, 0};
        if (is_locked_ || std::abs(there.x) >= wall_ahead || std::abs(there.y) >= wall_aside) return false;
        there_ = there;
        return true;
    });
}

void Car::add_streams() {
    every(at_rate(hz()), [this] {
        const Vector rates = hand_.holds() ? Vector{} : Vector{0, 0, yaw_rate_};
        emit(inertial_.inertial(held_.inverse().turn({gain_, speed_ * yaw_rate_, gravity}), rates, chance()));
    });
    every(at_rate(hz()), [this] {
        emit(euler_of(hand_.holds() ? held_.angles() : Angles{0, 0, yaw_}, euler_signs(), chance()));
    });
    every(at_rate(hz() / 2), [this] { emit(inertial_.compass(hand_.holds() ? held_ : Attitude::of({0, 0, yaw_}), chance())); });
    every(at_rate(hz() / 2), [this] { movement(); });
    every(at_rate(hz() / 5), [this] { surroundings(); });
    every(at_rate(1), [this] { health(); });
}

void Car::movement() {
    Draft<"velocity"> velocity;
    fill<"speed_x">(velocity, 100 * speed_ * std::cos(yaw_));
    fill<"speed_y">(velocity, 100 * speed_ * std::sin(yaw_));
    emit(velocity);
    Draft<"position"> position;
    fill<"pos_x">(position, 100 * position_.x);
    fill<"pos_y">(position, 100 * position_.y);
    emit(position);
}

void Car::surroundings() {
    const Scan points = scan_from(position_, yaw_);
    Draft<"ranging", "scan"> scan;
    static_cast<void>(scan.set<"points">(Bytes{points}));
    emit(scan);
    constexpr double forward = 1;
    Draft<"ranging"> ahead;
    fill<"type">(ahead, forward);
    fill<"dist">(ahead, 1000 * to_the_wall(position_, yaw_));
    emit(ahead);
}

void Car::health() {
    Draft<"mode"> mode;
    fill<"sflag">(mode, is_locked_ ? 0 : 1);
    emit(mode);
    Draft<"power"> power;
    fill<"voltage">(power, battery_.voltage());
    fill<"current">(power, battery_.current());
    emit(power);
}

// 0x40: the pitch stick sets the speed, the roll stick the turn. 0x41: forward speed and turn.
void Car::heard(FrameView frame) {
    if (const auto sticks = as<"remote_control">(frame)) {
        const bool is_linked = sticks->get<"pit">() != 0 && sticks->get<"rol">() != 0;
        const auto stick = [](int wire) { return std::clamp((wire - 1500) / 500.0, -1.0, 1.0); };
        steered_ = {stick(sticks->get<"pit">()) * top_speed_ / 100, -stick(sticks->get<"rol">()) * turn_ * degree};
        steered_age_ = is_linked ? 0 : input_lasts;
    } else if (const auto control = as<"realtime_control">(frame)) {
        steered_ = {control->get<"ctrl_spd_x">() / 100.0, control->get<"ctrl_yaw_dps">() * degree};
        steered_age_ = 0;
    }
}

// Sticks and 0x41 have priority, then the target of a command. Without any of them the car stops.
Car::Aim Car::aim() noexcept {
    if (is_locked_ || battery_.charge() <= 0) return {};
    if (steered_age_ < input_lasts) {
        there_.reset();
        return steered_;
    }
    return there_ ? towards(*there_) : Aim{};
}

Car::Aim Car::towards(Vector there) noexcept {
    const Vector left = there - position_;
    if (left.length() < 0.1) {
        there_.reset();
        return {};
    }
    const double off = wrapped(std::atan2(left.y, left.x) - yaw_);
    const bool is_ahead = std::abs(off) < 30 * degree;
    return {is_ahead ? std::min(left.length(), top_speed_ / 100.0) : 0, 3 * off};
}

void Car::advance() {
    steered_age_ += dt;
    held_ = hand_.holds() ? hand_.next(dt) : Attitude{};
    const Aim wanted = aim();
    const double top = top_speed_ / 100.0, max_gain = acceleration_ / 100.0, turn = turn_ * degree;
    gain_ = std::clamp((std::clamp(wanted.speed, -top, top) - speed_) / dt, -max_gain, max_gain);
    speed_ += dt * gain_;
    yaw_rate_ = std::clamp(wanted.yaw_rate, -turn, turn);
    yaw_ = wrapped(yaw_ + dt * yaw_rate_);
    position_ = position_ + dt * speed_ * Vector{std::cos(yaw_), std::sin(yaw_), 0};
    constexpr double bumper = 0.2;
    position_.x = std::clamp(position_.x, bumper - wall_ahead, wall_ahead - bumper);
    position_.y = std::clamp(position_.y, bumper - wall_aside, wall_aside - bumper);
    battery_.step(dt, std::abs(speed_) / top, driving_time_);
}

}    // namespace ano::world
