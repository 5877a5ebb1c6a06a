// The messages of the simulated LX IMU.
#include "lx_unit.hpp"
#include "say_attitude.hpp"

#include <algorithm>

namespace ano::world {
namespace {

using std::chrono::milliseconds;

constexpr double acc_of_a_g = 1365.33, cm_of_a_g = 980.665, gyro_of_a_degree = 32768.0 / 2000;
constexpr std::size_t max_data = 250;

std::int16_t rounded(double value) noexcept {
    return static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0, 32767.0)));
}
std::int32_t rounded_cm(double metres) noexcept { return static_cast<std::int32_t>(std::lround(100 * metres)); }

template <class... Numbers>
auto packed(Numbers... numbers) noexcept {
    std::array<std::uint8_t, (sizeof(Numbers) + ...)> data{};
    std::uint8_t* at = data.data();
    ((ano::store(at, numbers), at += sizeof numbers), ...);
    return data;
}

}    // namespace

// Measured behind a data radio (protocol-v7.md, section 3).
const std::array<LxUnit::Message, 15>& LxUnit::messages() {
    static const std::array<Message, 15> all{{
        {0x01, 300, milliseconds{20}, &LxUnit::inertial},
        {0x02, 301, milliseconds{50}, &LxUnit::compass},
        {0x03, 302, milliseconds{25}, &LxUnit::euler},
        {0x04, 303, milliseconds{25}, &LxUnit::quaternion},
        {0x05, 304, milliseconds{50}, &LxUnit::altitude},
        {0x06, 305, milliseconds{300}, &LxUnit::mode},
        {0x07, 306, milliseconds{50}, &LxUnit::velocity},
        {0x08, 307, milliseconds{100}, &LxUnit::position},
        {0x09, 308, milliseconds{100}, &LxUnit::wind},
        {0x0D, 312, milliseconds{300}, &LxUnit::power},
        {0x0E, 313, milliseconds{300}, &LxUnit::modules},
        {0x20, 314, milliseconds{20}, &LxUnit::outputs},
        {0x30, 316, milliseconds{200}, &LxUnit::satellites},
        {0x40, 320, milliseconds{200}, &LxUnit::sticks},
        {0x41, 321, milliseconds{100}, &LxUnit::steering},
    }};
    return all;
}

LxUnit::LxUnit(const Settings& settings, TimePoint start)
    : SimulatedDevice{{.id = settings.id != 0 ? settings.id : usual_id, .name = "SimLX"}, settings, start},
      flight_{settings_, [this](std::string_view text, bool is_bad) { say(text, is_bad); }},
      accelerometer_{chance()},
      compass_{chance()},
      gyroscope_{chance()},
      satellites_{~settings.seed} {
    restore_defaults();
    store();
    for (std::size_t i = 0; i < 4; ++i)
        if (i != 2) ano::store(sticks_.data() + 2 * i, std::int16_t{1500});
    ano::store(sticks_.data() + 4, std::int16_t{1000});
    for (std::size_t i = 4; i < 10; ++i) ano::store(sticks_.data() + 2 * i, std::int16_t{1500});
    every(step, [this] { emit_due(); });
}

void LxUnit::advance() {
    flight_.step(dt, chance());
    if (std::chrono::duration<double>{store_at_}.count() <= time()) store();
}

// `hz` of the settings is the rate of 0x01; the others are scaled with it. A period of 0 switches a message off.
void LxUnit::emit_due() {
    if (is_erased_) return;
    const Duration now = std::chrono::round<Duration>(std::chrono::duration<double>{time()});
    constexpr int usual_hz = 50;
    for (Message& message : messages_) {
        const std::int32_t ms = parameters_[message.period];
        if (ms <= 0 || now < message.next) continue;
        (this->*message.emit)();
        message.next = std::max(message.next, now - step) + Duration{milliseconds{ms}} * usual_hz / static_cast<int>(hz());
    }
    constexpr double private_rate = 383;
    for (private_ones_ += private_rate * dt * hz() / usual_hz; private_ones_ >= 1; --private_ones_) private_message();
}

void LxUnit::emit_v7(std::uint8_t id, Bytes data) {
    std::array<std::uint8_t, v7::overhead + max_data> frame;
    const std::size_t size = v7::encode(frame, v7::address::host, id, data);
    if (size != 0) emit_bytes(std::span{frame}.first(size));
}

// A message whose DATA are the same in V8.
template <class Draft>
void LxUnit::emit_same(const Draft& draft) {
    std::array<std::uint8_t, overhead + max_data> frame;
    const std::size_t size = draft.encode(frame, 0, 0);
    emit_v7(Draft::message().id, FrameView{std::span{frame}.first(size)}.data());
}

void LxUnit::say(std::string_view text, bool is_bad) {
    constexpr std::uint8_t red = 1, green = 2;
    std::vector<std::uint8_t> data{is_bad ? red : green};
    data.insert(data.end(), text.begin(), text.end());
    emit_v7(0xA0, data);
}

void LxUnit::inertial() {
    const Vector a = accelerometer_.corrected(accelerometer_.measure(flight_.body().felt(), chance()));
    const Vector turns = gyroscope_.measure(flight_.body().rates(), chance());
    constexpr double raw = acc_of_a_g / cm_of_a_g;
    emit_v7(0x01, packed(rounded(raw * a.x), rounded(raw * a.y), rounded(raw * a.z), rounded(gyro_of_a_degree * turns.x),
                         rounded(gyro_of_a_degree * turns.y), rounded(gyro_of_a_degree * turns.z), std::uint8_t{0}));
}

void LxUnit::compass() {
    const Vector m = compass_.corrected(compass_.measure(flight_.body().attitude(), chance()));
    const double height = flight_.body().position().z + 0.05 * chance().normal();
    const double celsius = 44 + 0.1 * chance().normal();
    emit_v7(0x02, packed(rounded(m.x), rounded(m.y), rounded(m.z), rounded_cm(height), rounded(100 * celsius), std::uint8_t{1},
                         std::uint8_t{1}));
}

// An LX IMU sends pitch and yaw with the opposite sign of its quaternion.
void LxUnit::euler() { emit_same(euler_of(flight_.body().angles(), EulerSigns::lx, chance())); }
void LxUnit::quaternion() { emit_same(quaternion_of(flight_.body().attitude())); }

void LxUnit::altitude() {
    const double height = flight_.body().position().z;
    emit_v7(0x05, packed(rounded_cm(height), rounded_cm(height + 0.01 * chance().normal()), std::uint8_t{1}));
}

void LxUnit::mode() {
    const bool runs = flight_.task() != Flight::Task::hover;
    const bool is_unlocked = flight_.safety() != Flight::Safety::locked;
    emit_v7(0x06, std::array<std::uint8_t, 5>{settings_.mode, is_unlocked, runs ? running_[0] : std::uint8_t{0},
                                              runs ? running_[1] : std::uint8_t{0}, runs ? running_[2] : std::uint8_t{0}});
}

void LxUnit::velocity() {
    const Vector v = 100 * flight_.body().velocity();
    emit_v7(0x07, packed(rounded(v.x), rounded(v.y), rounded(v.z)));
}

void LxUnit::position() {
    const Vector p = flight_.offset();
    emit_v7(0x08, packed(rounded_cm(p.x), rounded_cm(p.y)));
}

void LxUnit::wind() {
    const Vector w = flight_.safety() == Flight::Safety::airborne ? 100 * flight_.wind() : Vector{};
    emit_v7(0x09, packed(rounded(w.x), rounded(w.y)));
}

void LxUnit::power() {
    emit_v7(0x0D, packed(rounded(100 * flight_.battery().voltage()), rounded(100 * flight_.battery().current())));
}

void LxUnit::modules() { emit_v7(0x0E, std::array<std::uint8_t, 4>{2, 0, 3, 2}); }

void LxUnit::outputs() {
    constexpr double full = 10000;
    const Motors& m = flight_.body().motors();
    emit_v7(0x20, packed(rounded(full * m[0]), rounded(full * m[1]), rounded(full * m[2]), rounded(full * m[3])));
}

void LxUnit::satellites() { emit_same(satellites_.look(flight_.body().position(), flight_.body().velocity(), home_)); }

void LxUnit::sticks() { emit_v7(0x40, sticks_); }
void LxUnit::steering() { emit_v7(0x41, steering_); }
void LxUnit::private_message() { emit_v7(0xFA, std::array<std::uint8_t, 2>{0x08, 0}); }

}    // namespace ano::world
