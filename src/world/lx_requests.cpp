// The requests that the simulated LX IMU answers (protocol-v7.md, sections 5 and 6).
#include "lx_unit.hpp"

#include <algorithm>

namespace ano::world {
namespace {

constexpr std::int32_t no_such_parameter = INT32_MIN;
constexpr std::uint16_t first_setting = 151, last_setting = 165, first_period = 300, last_period = 321;
constexpr std::uint16_t first_calibration = 1000, last_of_accelerometer = 1014, first_of_compass = 1015, last_calibration = 1020;
constexpr std::uint8_t first_of_matrix = 6;
constexpr std::size_t command_size = 11, max_commands = 10'000;

// The number in the device for 1.
double scale_of(std::size_t row) noexcept { return row >= first_of_matrix && row < 15 ? 100'000 : 1000; }

constexpr std::uint32_t number_of(std::uint32_t cid, std::uint32_t cmd0, std::uint32_t cmd1) noexcept {
    return cid << 16 | cmd0 << 8 | cmd1;
}

constexpr std::array<float, 15> no_accelerometer_calibration{0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
constexpr std::array<float, 6> no_compass_calibration{0, 0, 0, 1, 1, 1};

}    // namespace

std::span<const LxUnit::Command> LxUnit::known_commands() {
    constexpr Class b = Class::not_in_mode_0, c = Class::only_in_mode_3;
    static constexpr Command all[]{
        {number_of(0x01, 0x00, 0x01), &LxUnit::done},
        {number_of(0x01, 0x00, 0x02), &LxUnit::done},
        {number_of(0x01, 0x00, 0x03), &LxUnit::done},
        {number_of(0x01, 0x00, 0x04), &LxUnit::done},
        {number_of(0x01, 0x00, 0x05), &LxUnit::done},
        {number_of(0x01, 0x00, 0x61), &LxUnit::store_waypoints},
        {number_of(0x01, 0x00, 0x62), &LxUnit::clear_waypoints},
        {number_of(0x01, 0x00, 0xAB), &LxUnit::restore},
        {number_of(0x01, 0x00, 0xAC), &LxUnit::restore},
        {number_of(0x01, 0x01, 0x01), &LxUnit::set_mode},
        {number_of(0x01, 0x30, 0x01), &LxUnit::begin_accelerometer},
        {number_of(0x01, 0x30, 0x02), &LxUnit::begin_compass},
        {number_of(0x01, 0x30, 0x11), &LxUnit::begin_accelerometer},
        {number_of(0x01, 0x20, 0xAA), &LxUnit::erase},
        {number_of(0x10, 0x00, 0x01), &LxUnit::unlock},
        {number_of(0x10, 0x00, 0x02), &LxUnit::stop},
        {number_of(0x10, 0x00, 0x04), &LxUnit::hover},
        {number_of(0x10, 0x00, 0x05), &LxUnit::take_off, b},
        {number_of(0x10, 0x00, 0x06), &LxUnit::land, b},
        {number_of(0x10, 0x00, 0x07), &LxUnit::return_home, c},
        {number_of(0x10, 0x00, 0x60), &LxUnit::fly_waypoints, c},
        {number_of(0x10, 0x00, 0x61), &LxUnit::hover, c},
        {number_of(0x10, 0x00, 0x62), &LxUnit::hover, c},
        {number_of(0x10, 0x01, 0x01), &LxUnit::target_position, c},
        {number_of(0x10, 0x01, 0x02), &LxUnit::target_height, c},
        {number_of(0x10, 0x02, 0x01), &LxUnit::up, c},
        {number_of(0x10, 0x02, 0x02), &LxUnit::down, c},
        {number_of(0x10, 0x02, 0x03), &LxUnit::move, c},
        {number_of(0x10, 0x02, 0x07), &LxUnit::turn_left, c},
        {number_of(0x10, 0x02, 0x08), &LxUnit::turn_right, c},
        {number_of(0x10, 0x03, 0x01), &LxUnit::target_place, c},
    };
    return all;
}

// As real devices: frames for others are dropped, and so are those without DATA.
void LxUnit::receive(Bytes bytes, TimePoint now, const Send& send) {
    const auto frame = v7::frame_at(bytes);
    if (!frame || frame->bytes().size() != bytes.size() || frame->data().empty()) return;
    if (frame->destination() != v7::address::imu && frame->destination() != v7::address::broadcast) return;
    handle_at(now, send, [&] {
        if (!is_erased_) take(*frame);
    });
}

void LxUnit::take(v7::FrameView frame) {
    const Bytes data = frame.data();
    const std::uint8_t id = frame.id();
    if ((id >= 0x01 && id <= 0x0F) || id == 0x20 || id == 0x21) {
        ++false_measurements_;
        return;
    }
    if (id == 0xE0 && data.size() == command_size) {
        acknowledge(frame);
        command(data);
    } else if (id == 0xE1 && data.size() == 2) {
        read_parameter(ano::load<std::uint16_t>(data.data()));
    } else if (id == 0xE2 && data.size() == 6) {
        write_parameter(ano::load<std::uint16_t>(data.data()), ano::load<std::int32_t>(data.data() + 2));
        acknowledge(frame);
    } else if (id == 0x60 && data.size() == 1) {
        read_waypoint(data[0]);
    } else if (id == 0x61 && data.size() == std::tuple_size_v<Waypoint>) {
        std::copy(data.begin(), data.end(), waypoints_[data[0]].begin());
        acknowledge(frame);
    } else if (id == 0x40 && data.size() == sticks_.size()) {
        std::copy(data.begin(), data.end(), sticks_.begin());
    } else if (id == 0x41 && data.size() == steering_.size()) {
        std::copy(data.begin(), data.end(), steering_.begin());
    }
}

void LxUnit::acknowledge(v7::FrameView frame) {
    emit_v7(0x00, std::array<std::uint8_t, 3>{frame.id(), frame.checks().sum, frame.checks().add});
}

// A command in the wrong mode is dropped without an answer; 0x06 shows which one runs.
void LxUnit::command(Bytes data) {
    auto& kept = commands_.emplace_back();
    std::copy(data.begin(), data.end(), kept.begin());
    if (commands_.size() > max_commands) commands_.erase(commands_.begin());
    const std::uint32_t id = number_of(data[0], data[1], data[2]);
    const auto known = known_commands();
    const auto row = std::find_if(known.begin(), known.end(), [&](const Command& one) { return one.id == id; });
    if (row == known.end()) return;
    if (row->when == Class::not_in_mode_0 && settings_.mode == 0) return;
    if (row->when == Class::only_in_mode_3 && settings_.mode != 3) return;
    if (data[0] == 0x10) running_ = {data[0], data[1], data[2]};
    (this->*row->run)(data.data() + 3);
}

std::int32_t LxUnit::parameter(std::uint16_t number) const {
    if (number >= first_calibration && number <= last_calibration) return calibration(number);
    const auto found = parameters_.find(number);
    return found == parameters_.end() ? no_such_parameter : found->second;
}

void LxUnit::read_parameter(std::uint16_t number) {
    std::array<std::uint8_t, 6> answer{};
    ano::store(answer.data(), number);
    ano::store(answer.data() + 2, parameter(number));
    emit_v7(0xE2, answer);
}

// Stored 3 s after the last write; a calibration at once, with its last number. The numbers of its type and versions stay.
void LxUnit::write_parameter(std::uint16_t number, std::int32_t value) {
    if (write_calibration(number, value)) {
        const bool is_last = number == last_of_accelerometer || number == last_calibration;
        if (!is_last) return;
        flight_.hand().finish();
        return store();
    }
    const auto found = parameters_.find(number);
    if (found == parameters_.end() || number < first_setting) return;
    found->second = value;
    constexpr double later = 3;    // s
    store_at_ = std::chrono::round<Duration>(std::chrono::duration<double>{time() + later});
}

bool LxUnit::write_calibration(std::uint16_t number, std::int32_t value) {
    if (number < first_calibration || number > last_calibration) return false;
    const std::size_t row = number - first_calibration;
    const auto real = static_cast<float>(value / scale_of(row));
    if (number < first_of_compass) accelerometer_.calibration[row] = real;
    else compass_.calibration[number - first_of_compass] = real;
    return true;
}

std::int32_t LxUnit::calibration(std::uint16_t number) const {
    const std::size_t row = number - first_calibration;
    const float real = number < first_of_compass ? accelerometer_.calibration[row]
                                                 : compass_.calibration[number - first_of_compass];
    return static_cast<std::int32_t>(std::lround(static_cast<double>(real) * scale_of(row)));
}

void LxUnit::restore_defaults() {
    parameters_ = {{1, v7::address::imu}, {2, 1}, {3, 17}, {4, 1}};
    for (std::uint16_t number = first_setting; number <= last_setting; ++number) parameters_[number] = 0;
    parameters_[162] = parameters_[163] = 500000;
    for (std::uint16_t number = first_period; number <= last_period; ++number) parameters_[number] = 0;
    for (const Message& message : messages_)
        parameters_[message.period] = static_cast<std::int32_t>(message.usual_period / std::chrono::milliseconds{1});
    accelerometer_.calibration = no_accelerometer_calibration;
    compass_.calibration = no_compass_calibration;
}

void LxUnit::store() {
    store_at_ = Duration::max();
    stored_ = parameters_;
    stored_accelerometer_ = accelerometer_.calibration;
    stored_compass_ = compass_.calibration;
}

void LxUnit::restart() {
    parameters_ = stored_;
    waypoints_ = stored_waypoints_;
    accelerometer_.calibration = stored_accelerometer_;
    compass_.calibration = stored_compass_;
    store_at_ = Duration::max();
}

void LxUnit::read_waypoint(std::uint8_t number) {
    constexpr std::uint8_t how_many = 0xFF;
    if (number == how_many) return emit_v7(0x60, std::array{static_cast<std::uint8_t>(waypoints_.size())});
    if (const auto found = waypoints_.find(number); found != waypoints_.end()) emit_v7(0x61, found->second);
}

void LxUnit::set_mode(const std::uint8_t* values) {
    if (values[0] <= 3) settings_.mode = values[0];
}

void LxUnit::begin_accelerometer(const std::uint8_t*) {
    constexpr double samples_of_a_face = 90;
    accelerometer_.calibration = no_accelerometer_calibration;
    if (flight_.may_be_turned()) flight_.hand().turn_to_faces(1 + samples_of_a_face / hz());
}

void LxUnit::begin_compass(const std::uint8_t*) {
    constexpr double samples_all_round = 500, usual_hz = 50, compass_hz = 20;
    compass_.calibration = no_compass_calibration;
    if (flight_.may_be_turned())
        flight_.hand().turn_all_round(Compass::earth, samples_all_round / (compass_hz * hz() / usual_hz));
}

void LxUnit::take_off(const std::uint8_t* values) {
    const auto cm = ano::load<std::uint16_t>(values);
    flight_.take_off((cm == 0 ? settings_.height : cm) / 100.0);
}

void LxUnit::fly_waypoints(const std::uint8_t*) {
    constexpr double to_degrees = 1e-7;
    constexpr std::uint16_t to_the_target = 400;
    std::vector<RoutePoint> route;
    for (const auto& [number, bytes] : waypoints_) {
        const Place place{ano::load<std::int32_t>(bytes.data() + 1) * to_degrees,
                          ano::load<std::int32_t>(bytes.data() + 5) * to_degrees};
        const double height = ano::load<std::int32_t>(bytes.data() + 9) / 100.0;
        RoutePoint point{.there = from_home(place, home_) + Vector{0, 0, height},
                         .speed = ano::load<std::uint16_t>(bytes.data() + 13) / 100.0};
        const auto yaw = ano::load<std::uint16_t>(bytes.data() + 15);
        if (yaw != to_the_target) point.yaw = wrapped(-yaw * degree);
        route.push_back(point);
    }
    flight_.fly(std::move(route));
}

void LxUnit::target_position(const std::uint8_t* values) {
    go_to({ano::load<std::int32_t>(values) / 100.0, ano::load<std::int32_t>(values + 4) / 100.0, flight_.offset().z});
}

void LxUnit::target_height(const std::uint8_t* values) {
    const Vector here = flight_.offset();
    go_to({here.x, here.y, ano::load<std::int32_t>(values) / 100.0});
}

void LxUnit::up(const std::uint8_t* values) { go_to(flight_.offset() + Vector{0, 0, ano::load<std::uint16_t>(values) / 100.0}); }

void LxUnit::down(const std::uint8_t* values) {
    go_to(flight_.offset() - Vector{0, 0, ano::load<std::uint16_t>(values) / 100.0});
}

void LxUnit::move(const std::uint8_t* values) {
    const double metres = ano::load<std::uint16_t>(values) / 100.0;
    const double direction = flight_.body().angles().yaw - ano::load<std::uint16_t>(values + 4) * degree;
    go_to(flight_.offset() + Vector{metres * std::cos(direction), metres * std::sin(direction), 0});
}

void LxUnit::turn_left(const std::uint8_t* values) {
    flight_.yaw(flight_.body().angles().yaw + ano::load<std::uint16_t>(values) * degree);
}

void LxUnit::turn_right(const std::uint8_t* values) {
    flight_.yaw(flight_.body().angles().yaw - ano::load<std::uint16_t>(values) * degree);
}

void LxUnit::target_place(const std::uint8_t* values) {
    constexpr double to_degrees = 1e-7;
    const Place place{ano::load<std::int32_t>(values) * to_degrees, ano::load<std::int32_t>(values + 4) * to_degrees};
    const Vector there = from_home(place, home_) - (flight_.body().position() - flight_.offset());
    go_to({there.x, there.y, flight_.offset().z});
}

}    // namespace ano::world
