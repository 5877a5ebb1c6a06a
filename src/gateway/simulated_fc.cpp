#include <ano/address.hpp>
#include <ano/messages.hpp>
#include <ano/typed.hpp>
#include <gateway/simulated_fc.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <type_traits>

namespace anogate {
namespace {

constexpr double gravity = 981;           // cm/s²
constexpr double full_battery = 12.6;     // V
constexpr double empty_battery = 10.8;    // V

// What it says is within what the fields carry; those without a scale carry whole numbers only.
template <ano::Name F, class Draft, class Value>
void set(Draft& draft, Value value) {
    bool fits = draft.template set<F>(value);
    if constexpr (std::is_floating_point_v<Value>)
        if (!fits) fits = draft.template set<F>(std::round(value));
    assert(fits);
    static_cast<void>(fits);
}

// What a calibration makes of it need not fit.
double within_i16(double value) noexcept { return std::isnan(value) ? 0 : std::clamp(value, -32768.0, 32767.0); }

template <class Draft>
void send(const Draft& draft, const SimulatedFc::Send& out) {
    std::array<std::uint8_t, 72> buffer;
    const std::size_t size = draft.encode(buffer, ano::address::flight_controller, ano::address::host);
    out(ano::FrameView{{buffer.data(), size}});
}

}    // namespace

SimulatedFc::SimulatedFc(unsigned rate, ano::TimePoint start)
    : device_{{.id = ano::address::flight_controller, .name = "SimFC"}}, start_{start} {
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

void SimulatedFc::receive(ano::FrameView frame, ano::TimePoint now, const Send& send) {
    device_.take(frame, now);
    while (const auto out = device_.next()) send(out->frame);
}

void SimulatedFc::inertial(double t, const Send& out) const {
    ano::Draft<"inertial"> draft;
    const auto acceleration = setup_.corrected({8 * std::sin(1.1 * t), 8 * std::cos(0.9 * t), gravity + 5 * std::sin(2.3 * t)});
    set<"acc_x">(draft, within_i16(acceleration[0]));
    set<"acc_y">(draft, within_i16(acceleration[1]));
    set<"acc_z">(draft, within_i16(acceleration[2]));
    set<"gyr_x">(draft, 3 * std::cos(0.7 * t));
    set<"gyr_y">(draft, 2 * std::cos(0.5 * t));
    set<"gyr_z">(draft, setup_.turn());
    send(draft, out);
}

void SimulatedFc::euler(double t, const Send& out) const {
    ano::Draft<"euler"> draft;
    set<"rol">(draft, setup_.sway() * std::sin(0.7 * t));
    set<"pit">(draft, 0.75 * setup_.sway() * std::sin(0.5 * t));
    set<"yaw">(draft, std::remainder(setup_.turn() * t, 360));
    set<"fusion_sta">(draft, 1);
    send(draft, out);
}

void SimulatedFc::altitude(double t, const Send& out) const {
    const double height = setup_.height() + setup_.sway() * std::sin(0.4 * t);
    ano::Draft<"altitude"> draft;
    set<"alt_bar">(draft, height + setup_.barometer_offset());
    set<"alt_add">(draft, height + setup_.range_offset());
    set<"alt_fu">(draft, height);
    set<"alt_sta">(draft, 1);
    send(draft, out);
}

void SimulatedFc::mode(double, const Send& out) const {
    constexpr unsigned locked = 0, airborne = 2;
    ano::Draft<"mode"> draft;
    set<"mode">(draft, setup_.mode());
    set<"sflag">(draft, setup_.flies() ? airborne : locked);
    send(draft, out);
}

void SimulatedFc::velocity(double t, const Send& out) const {
    ano::Draft<"velocity"> draft;
    const double speed = setup_.flies() ? 5 : 0;
    set<"speed_x">(draft, speed * std::sin(0.3 * t));
    set<"speed_y">(draft, speed * std::cos(0.3 * t));
    set<"speed_z">(draft, 0.4 * setup_.sway() * std::cos(0.4 * t));
    send(draft, out);
}

void SimulatedFc::power(double t, const Send& out) const {
    const double used = std::fmod(t, setup_.flight_time()) / setup_.flight_time();
    ano::Draft<"power"> draft;
    set<"voltage">(draft, full_battery - (full_battery - empty_battery) * used);
    set<"current">(draft, 14 + std::sin(0.4 * t));
    send(draft, out);
}

}    // namespace anogate
