#include <ano/address.hpp>
#include <ano/messages.hpp>
#include <ano/typed.hpp>
#include <gateway/simulated_fc.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string_view>
#include <type_traits>

namespace anogate {
namespace {

constexpr double gravity = 981;           // cm/s²
constexpr double hover_height = 120;      // cm
constexpr double full_battery = 12.6;     // V
constexpr double empty_battery = 10.8;    // V
constexpr double flight_time = 900;       // s until it starts again with a full one

constexpr std::uint8_t cmd_device_info = 0;

// What it says is within what the fields carry; those without a scale carry whole numbers only.
template <ano::Name F, class Draft, class Value>
void set(Draft& draft, Value value) {
    bool fits = draft.template set<F>(value);
    if constexpr (std::is_floating_point_v<Value>)
        if (!fits) fits = draft.template set<F>(std::round(value));
    assert(fits);
    static_cast<void>(fits);
}

template <class Draft>
void send(const Draft& draft, std::uint8_t destination, const SimulatedFc::Send& out) {
    std::array<std::uint8_t, 72> buffer;
    const std::size_t size = draft.encode(buffer, ano::address::flight_controller, destination);
    out(ano::FrameView{{buffer.data(), size}});
}

template <class Draft>
void send(const Draft& draft, const SimulatedFc::Send& out) {
    send(draft, ano::address::host, out);
}

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
    if (frame.id() != ano::id_of<"parameter_command"> || frame.data().empty() || frame.data()[0] != cmd_device_info) return;
    ano::Draft<"device_info"> info;
    set<"dev_id">(info, address::flight_controller);
    set<"hw_ver">(info, 100);
    set<"sw_ver">(info, 100);
    set<"bl_ver">(info, 0);
    set<"pt_ver">(info, 800);
    set<"name">(info, std::string_view{"SimFC"});
    anogate::send(info, frame.source(), send);
}

void SimulatedFc::inertial(double t, const Send& out) const {
    ano::Draft<"inertial"> draft;
    set<"acc_x">(draft, 8 * std::sin(1.1 * t));
    set<"acc_y">(draft, 8 * std::cos(0.9 * t));
    set<"acc_z">(draft, gravity + 5 * std::sin(2.3 * t));
    set<"gyr_x">(draft, 3 * std::cos(0.7 * t));
    set<"gyr_y">(draft, 2 * std::cos(0.5 * t));
    set<"gyr_z">(draft, 6);
    send(draft, out);
}

void SimulatedFc::euler(double t, const Send& out) const {
    ano::Draft<"euler"> draft;
    set<"rol">(draft, 4 * std::sin(0.7 * t));
    set<"pit">(draft, 3 * std::sin(0.5 * t));
    set<"yaw">(draft, std::remainder(6 * t, 360));
    set<"fusion_sta">(draft, 1);
    send(draft, out);
}

void SimulatedFc::altitude(double t, const Send& out) const {
    const double height = hover_height + 4 * std::sin(0.4 * t);
    ano::Draft<"altitude"> draft;
    set<"alt_bar">(draft, height + 15);
    set<"alt_add">(draft, height);
    set<"alt_fu">(draft, height);
    set<"alt_sta">(draft, 1);
    send(draft, out);
}

void SimulatedFc::mode(double, const Send& out) const {
    constexpr unsigned position_hold = 3;
    constexpr unsigned airborne = 2;
    ano::Draft<"mode"> draft;
    set<"mode">(draft, position_hold);
    set<"sflag">(draft, airborne);
    send(draft, out);
}

void SimulatedFc::velocity(double t, const Send& out) const {
    ano::Draft<"velocity"> draft;
    set<"speed_x">(draft, 5 * std::sin(0.3 * t));
    set<"speed_y">(draft, 5 * std::cos(0.3 * t));
    set<"speed_z">(draft, 1.6 * std::cos(0.4 * t));
    send(draft, out);
}

void SimulatedFc::power(double t, const Send& out) const {
    const double used = std::fmod(t, flight_time) / flight_time;
    ano::Draft<"power"> draft;
    set<"voltage">(draft, full_battery - (full_battery - empty_battery) * used);
    set<"current">(draft, 14 + std::sin(0.4 * t));
    send(draft, out);
}

}    // namespace anogate
