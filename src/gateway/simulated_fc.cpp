#include <ano/address.hpp>
#include <gateway/simulated_fc.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace anogate {
namespace {

// Function codes of what it says and hears (protocol text, section 4).
enum : std::uint8_t {
    id_inertial = 0x01,
    id_euler = 0x03,
    id_altitude = 0x05,
    id_mode = 0x06,
    id_velocity = 0x07,
    id_power = 0x0D,
    id_parameter_command = 0xE0,
    id_device_info = 0xE3,
};
constexpr std::uint8_t cmd_device_info = 0;

constexpr double gravity = 981;           // cm/s²
constexpr double hover_height = 120;      // cm
constexpr double full_battery = 12.6;     // V
constexpr double empty_battery = 10.8;    // V
constexpr double flight_time = 900;       // s until it starts again with a full one

// DATA in the making: little-endian values, one behind the other.
class Payload {
public:
    Payload& u8(unsigned v) { return put(v, 1); }
    Payload& i16(double v) { return put(static_cast<std::uint64_t>(std::lround(v)), 2); }
    Payload& u16(double v) { return i16(v); }
    Payload& i32(double v) { return put(static_cast<std::uint64_t>(std::lround(v)), 4); }
    Payload& text(std::string_view s) {
        for (const char c : s) put(static_cast<unsigned char>(c), 1);
        return *this;
    }
    std::span<const std::uint8_t> bytes() const { return {bytes_.data(), size_}; }

private:
    Payload& put(std::uint64_t v, unsigned n) {
        for (unsigned i = 0; i < n; ++i) bytes_[size_++] = static_cast<std::uint8_t>(v >> (8 * i));
        return *this;
    }
    std::array<std::uint8_t, 64> bytes_{};
    std::size_t size_ = 0;
};

}    // namespace

SimulatedFc::SimulatedFc(unsigned rate, ano::TimePoint start) : start_{start} {
    using std::chrono::nanoseconds;
    const auto hz = [](unsigned r) {
        return std::chrono::duration_cast<ano::Duration>(nanoseconds{1'000'000'000} / std::max(r, 1u));
    };
    streams_ = {{
        {&SimulatedFc::inertial, hz(rate), start},
        {&SimulatedFc::euler, hz(rate), start},
        {&SimulatedFc::velocity, hz(rate / 2), start},
        {&SimulatedFc::altitude, hz(rate / 2), start},
        {&SimulatedFc::mode, hz(rate / 10), start},
        {&SimulatedFc::power, hz(1), start},
    }};
}

void SimulatedFc::run(ano::TimePoint now, const Send& send) {
    const double t = std::chrono::duration<double>(now - start_).count();
    for (Stream& stream : streams_) {
        if (now < stream.next) continue;
        (this->*stream.make)(t, send);
        stream.next = now - stream.next < stream.period ? stream.next + stream.period : now + stream.period;
    }
}

ano::TimePoint SimulatedFc::next() const noexcept {
    return std::min_element(streams_.begin(), streams_.end(), [](auto& a, auto& b) { return a.next < b.next; })->next;
}

void SimulatedFc::receive(ano::FrameView frame, const Send& send) const {
    namespace address = ano::address;
    if (frame.destination() != address::flight_controller && frame.destination() != address::broadcast) return;
    if (frame.id() != id_parameter_command || frame.data().empty() || frame.data()[0] != cmd_device_info) return;
    const auto info = Payload{}.u8(address::flight_controller).u16(100).u16(100).u16(0).u16(800).text("SimFC");
    std::array<std::uint8_t, 64> buffer;
    const std::size_t size = ano::encode(buffer, address::flight_controller, frame.source(), id_device_info, info.bytes());
    send(ano::FrameView{{buffer.data(), size}});
}

void SimulatedFc::send(std::uint8_t id, std::span<const std::uint8_t> data, const Send& send) const {
    namespace address = ano::address;
    std::array<std::uint8_t, 72> buffer;
    const std::size_t size = ano::encode(buffer, address::flight_controller, address::host, id, data);
    send(ano::FrameView{{buffer.data(), size}});
}

void SimulatedFc::inertial(double t, const Send& out) const {
    const double scale = 32768.0 / 2000;    // per °/s
    send(id_inertial,
         Payload{}
             .i16(8 * std::sin(1.1 * t))
             .i16(8 * std::cos(0.9 * t))
             .i16(gravity + 5 * std::sin(2.3 * t))
             .i16(scale * 3 * std::cos(0.7 * t))
             .i16(scale * 2 * std::cos(0.5 * t))
             .i16(scale * 6)
             .u8(0)
             .bytes(),
         out);
}

void SimulatedFc::euler(double t, const Send& out) const {
    const double yaw = std::remainder(6 * t, 360);
    send(id_euler, Payload{}.i16(100 * 4 * std::sin(0.7 * t)).i16(100 * 3 * std::sin(0.5 * t)).i16(100 * yaw).u8(1).bytes(), out);
}

void SimulatedFc::altitude(double t, const Send& out) const {
    const double height = hover_height + 4 * std::sin(0.4 * t);
    send(id_altitude, Payload{}.i32(height + 15).i32(height).i32(height).u8(1).bytes(), out);
}

void SimulatedFc::mode(double, const Send& out) const {
    constexpr unsigned position_hold = 3;
    constexpr unsigned airborne = 2;
    send(id_mode, Payload{}.u8(position_hold).u8(airborne).u8(0).u8(0).u8(0).bytes(), out);
}

void SimulatedFc::velocity(double t, const Send& out) const {
    send(id_velocity, Payload{}.i16(5 * std::sin(0.3 * t)).i16(5 * std::cos(0.3 * t)).i16(1.6 * std::cos(0.4 * t)).bytes(), out);
}

void SimulatedFc::power(double t, const Send& out) const {
    const double used = std::fmod(t, flight_time) / flight_time;
    const double volts = full_battery - (full_battery - empty_battery) * used;
    send(id_power, Payload{}.u16(100 * volts).u16(100 * (14 + std::sin(0.4 * t))).bytes(), out);
}

}    // namespace anogate
