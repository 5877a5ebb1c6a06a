#include "flight.hpp"

#include <numeric>
#include <utility>

namespace ano::world {
namespace {

constexpr double near = 0.15;    // m
constexpr Motors idle{0.05, 0.05, 0.05, 0.05};

bool is_within_reach(Vector there) noexcept {
    return std::hypot(there.x, there.y) <= Flight::max_distance && there.z >= Flight::min_height && there.z <= Flight::max_height;
}

}    // namespace

bool Sticks::centred() const noexcept {
    constexpr double small = 40 / 500.0, large = 80 / 500.0;    // dead zones of the protocol text
    return std::abs(roll) <= small && std::abs(pitch) <= small && std::abs(yaw) <= large;
}

Flight::Safety Flight::safety() const noexcept {
    if (is_locked_) return Safety::locked;
    return body_.on_ground() ? Safety::unlocked : Safety::airborne;
}

bool Flight::unlock() {
    if (hand_.holds() || battery_.charge() <= last_battery) return false;
    if (is_locked_) report_("unlocked", false);
    is_locked_ = false;
    return true;
}

bool Flight::lock() {
    if (safety() == Safety::airborne) return false;
    is_locked_ = true;
    task_ = Task::hover;
    return true;
}

void Flight::stop() {
    is_locked_ = true;
    task_ = Task::hover;
}

bool Flight::begin(Task task) {
    if (safety() != Safety::airborne) return false;
    task_ = task;
    return true;
}

bool Flight::take_off(double height) {
    if (height < min_height || height > max_height || !unlock()) return false;
    if (body_.on_ground()) pilot_.reset(body_);
    place_ = body_.position();
    place_.z = height;
    task_ = Task::take_off;
    return true;
}

bool Flight::land() {
    if (safety() == Safety::airborne) task_ = Task::land;
    else is_locked_ = true;
    return true;
}

bool Flight::hover() {
    place_ = body_.position();
    return begin(Task::hover);
}

bool Flight::go_to(Vector there) {
    if (!is_within_reach(there) || !begin(Task::go_to)) return false;
    place_ = from_ + there;
    return true;
}

bool Flight::yaw(double yaw) {
    aimed_yaw_ = wrapped(yaw);
    return begin(Task::yaw);
}

bool Flight::return_home() {
    if (!begin(Task::return_home)) return false;
    place_ = {from_.x, from_.y, std::max(body_.position().z, 2.0)};
    return true;
}

bool Flight::fly(std::vector<RoutePoint> route) {
    for (const RoutePoint& point : route)
        if (!is_within_reach(point.there)) return false;
    if (route.empty() || !begin(Task::route)) return false;
    route_ = std::move(route);
    next_ = 0;
    stayed_ = 0;
    return true;
}

// Moving the sticks takes over manual control.
void Flight::receive(const Sticks& sticks) noexcept {
    sticks_ = sticks;
    sticks_age_ = 0;
    if (sticks.centred() || settings_.mode == static_cast<std::uint8_t>(Mode::programmed) || task_ == Task::hover) return;
    task_ = Task::hover;
    place_ = body_.position();
}

void Flight::receive(const Steering& steering) noexcept {
    steering_ = steering;
    steering_age_ = 0;
}

void Flight::step(double dt, Noise& chance) {
    sticks_age_ += dt;
    steering_age_ += dt;
    weather_.step(dt, double{settings_.wind}, settings_.wind_from, double{settings_.sway} / 100, chance);
    if (hand_.holds()) return body_.hold(hand_.next(dt), dt);
    const Motors wanted = is_locked_ || battery_.charge() <= 0 ? Motors{} : motors(dt);
    body_.step(dt, wanted, weather_.wind());
    const double load = std::accumulate(body_.motors().begin(), body_.motors().end(), 0.0) / (4 * Body::hover);
    battery_.step(dt, load < 0.01 ? 0 : load, settings_.flight_time);
    if (!body_.on_ground()) left_the_ground();
    else if (std::exchange(flies_, false) && (task_ == Task::land || battery_.charge() <= 0)) landed();
    look_after_the_battery();
}

void Flight::left_the_ground() {
    if (std::exchange(flies_, true)) return;
    from_ = {body_.position().x, body_.position().y, 0};
    was_low_ = false;
}

void Flight::landed() {
    is_locked_ = true;
    task_ = Task::hover;
    report_("landed", false);
}

void Flight::look_after_the_battery() {
    if (safety() != Safety::airborne) return;
    if (battery_.charge() <= low_battery && !std::exchange(was_low_, true)) report_("battery low", true);
    if (battery_.charge() > last_battery || task_ == Task::land) return;
    report_("battery nearly empty: landing", true);
    place_ = body_.position();
    task_ = Task::land;
}

Motors Flight::motors(double dt) {
    if (task_ != Task::hover) return by_task(dt);
    if (body_.on_ground()) pilot_.reset(body_);
    else pilot_.turn(settings_.turn * degree, dt);
    return by_hand(dt);
}

void Flight::end() {
    task_ = Task::hover;
    report_("done", false);
}

Motors Flight::by_task(double dt) {
    const double speed = settings_.speed / 100.0;
    const bool there = (place_ - body_.position()).length() < near;
    switch (task_) {
    case Task::land: return pilot_.go(body_, {place_.x, place_.y, -1}, speed, settings_.gains, dt);
    case Task::route: return on_route(dt);
    case Task::yaw:
        pilot_.turn_towards(aimed_yaw_, dt);
        if (std::abs(wrapped(aimed_yaw_ - body_.angles().yaw)) < degree) end();
        break;
    case Task::return_home:
        if (there) task_ = Task::land;
        break;
    default:
        if (there) end();
    }
    return pilot_.go(body_, place_, speed, settings_.gains, dt);
}

// Turns towards the wanted direction; true if the vehicle faces it. Near the point, the direction to it is undefined: there the
// vehicle keeps its own.
bool Flight::faces(const RoutePoint& point, double dt) noexcept {
    constexpr double beside = 1;    // m
    const Vector way = place_ - body_.position();
    if (!point.yaw && std::hypot(way.x, way.y) < beside) return true;
    const double yaw = point.yaw ? *point.yaw : std::atan2(way.y, way.x);
    pilot_.turn_towards(yaw, dt);
    return std::abs(wrapped(yaw - body_.angles().yaw)) < 2 * degree;
}

Motors Flight::on_route(double dt) {
    const RoutePoint& point = route_[next_];
    place_ = point.there;
    const bool looks_there = faces(point, dt);
    if (looks_there && (place_ - body_.position()).length() < near) stayed_ += dt;
    const double speed = point.speed > 0 ? point.speed : settings_.speed / 100.0;
    const Motors motors = pilot_.go(body_, place_, speed, settings_.gains, dt);
    if (stayed_ <= point.stay) return motors;
    stayed_ = 0;
    if (++next_ == route_.size()) end();
    return motors;
}

// While hovering: follows the sticks and 0x41, as far as the mode allows.
Motors Flight::by_hand(double dt) {
    constexpr double stick_rate = 60 * degree, stick_climb = 2;
    const bool moved = has_sticks() && !sticks_.centred();
    const double thrown = 2 * sticks_.throttle - 1;
    const double climb = has_sticks() && std::abs(thrown) > 80 / 500.0 ? stick_climb * thrown : 0;
    switch (Mode{settings_.mode}) {
    case Mode::attitude:
    case Mode::height:
        if (has_sticks()) {
            pilot_.turn(-stick_rate * sticks_.yaw, dt);
            return leaning({Pilot::max_lean * sticks_.roll, Pilot::max_lean * sticks_.pitch, 0}, sticks_.throttle, climb, dt);
        }
        if (!is_steered()) break;
        pilot_.turn(steering_.yaw_rate, dt);
        return leaning(steering_.lean, steering_.throttle, steering_.velocity.z, dt);
    case Mode::position:
        if (moved || climb != 0) {
            pilot_.turn(-stick_rate * sticks_.yaw, dt);
            const double speed = settings_.speed / 100.0;
            return at_velocity({speed * sticks_.pitch, -speed * sticks_.roll, climb}, dt);
        }
        if (!is_steered()) break;
        pilot_.turn(steering_.yaw_rate, dt);
        return at_velocity(steering_.velocity, dt);
    case Mode::programmed: break;
    }
    return at_its_place(dt);
}

Motors Flight::at_its_place(double dt) {
    if (body_.on_ground()) return idle;
    return pilot_.go(body_, place_, settings_.speed / 100.0, settings_.gains, dt);
}

Motors Flight::leaning(Angles lean, double throttle, double climb, double dt) {
    place_ = body_.position();
    if (settings_.mode == static_cast<std::uint8_t>(Mode::attitude)) return pilot_.lean(body_, lean, throttle, settings_.gains);
    return may_climb(climb) ? pilot_.lean_and_climb(body_, lean, climb, settings_.gains, dt) : idle;
}

Motors Flight::at_velocity(Vector nose, double dt) {
    place_ = body_.position();
    if (!may_climb(nose.z)) return idle;
    const Vector over_ground = Attitude::of({0, 0, body_.angles().yaw}).turn({nose.x, nose.y, 0});
    return pilot_.fly(body_, {over_ground.x, over_ground.y, nose.z}, settings_.gains, dt);
}

}    // namespace ano::world
