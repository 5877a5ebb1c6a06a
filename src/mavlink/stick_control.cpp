#include <mavlink/stick_control.hpp>
#include <mavlink/typed.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace anogate::mavlink {
namespace {

constexpr double degree_per_radian = 180 / std::numbers::pi, max_yaw_rate = 200, max_lean = 90;

std::int16_t centimetres(double metres) noexcept { return limited<std::int16_t>(100 * metres); }
std::int16_t yaw_rate_to_the_left(double radians_to_the_right) noexcept {
    return limited<std::int16_t>(std::clamp(-degree_per_radian * radians_to_the_right, -max_yaw_rate, max_yaw_rate));
}

StickFault mode_fault(const VehicleState& state, const std::vector<std::uint8_t>& modes, ano::TimePoint now) noexcept {
    const FlightMode* const mode = state.mode.at(now);
    if (mode == nullptr) return StickFault::unknown_mode;
    return std::find(modes.begin(), modes.end(), mode->mode) == modes.end() ? StickFault::wrong_mode : StickFault::none;
}

}    // namespace

std::string_view format_fault(StickFault fault) noexcept {
    switch (fault) {
    case StickFault::none:
    case StickFault::not_sticks: return "";
    case StickFault::not_allowed: return "not allowed";
    case StickFault::other_station: return "from a second station";
    case StickFault::old: return "older than 0.2 s";
    case StickFault::malformed: return "not valid";
    case StickFault::wrong_mode: return "not followed in this flight mode";
    case StickFault::unknown_mode: return "flight mode not known (no 0x06)";
    }
    return "";
}

std::optional<StickInput> stick_input(PacketView packet, std::uint8_t& target_system) noexcept {
    if (const auto m = as<"MANUAL_CONTROL">(packet)) return target_system = m->get<"target">(), StickInput::manual_control;
    if (const auto m = as<"RC_CHANNELS_OVERRIDE">(packet))
        return target_system = m->get<"target_system">(), StickInput::rc_override;
    if (const auto m = as<"SET_POSITION_TARGET_LOCAL_NED">(packet))
        return target_system = m->get<"target_system">(), StickInput::velocity;
    if (const auto m = as<"SET_ATTITUDE_TARGET">(packet)) return target_system = m->get<"target_system">(), StickInput::attitude;
    return std::nullopt;
}

StickFault StickControl::receive(PacketView packet, ano::TimePoint received_at, ano::TimePoint now, const VehicleState& state,
                                 StickFrame& frame) {
    std::uint8_t target = 0;
    const auto input = stick_input(packet, target);
    if (!input) return StickFault::not_sticks;
    if (!settings_.accepts_input(*input)) return StickFault::not_allowed;
    const Origin from{packet.system(), packet.component()};
    const bool is_new = station_ != from || now - used_at_ >= silence;
    if (station_ && station_ != from && now - used_at_ < silence) return StickFault::other_station;
    const bool waited_here = now - received_at > max_age;
    bool waited_there = false;
    if (const auto m = as<"SET_POSITION_TARGET_LOCAL_NED">(packet)) waited_there = waited(m->get<"time_boot_ms">(), now, is_new);
    if (const auto m = as<"SET_ATTITUDE_TARGET">(packet)) waited_there = waited(m->get<"time_boot_ms">(), now, is_new);
    if (waited_here || waited_there) return StickFault::old;
    Outcome outcome = StickFault::malformed;
    switch (*input) {
    case StickInput::manual_control: outcome = channels_of_sticks(packet); break;
    case StickInput::rc_override: outcome = channels_of_override(packet); break;
    case StickInput::velocity: outcome = velocity_of(packet, now, state); break;
    case StickInput::attitude: outcome = attitude_of(packet, now, state); break;
    }
    if (const auto* fault = std::get_if<StickFault>(&outcome)) return *fault;
    frame = std::get<StickFrame>(outcome);
    station_ = from;
    used_at_ = now;
    if (std::holds_alternative<RealtimeFrame>(frame)) steering_ = *input;
    return StickFault::none;
}

// Relative to the shortest delay: the clocks differ. If all messages seem old for 5 s, the station's clock was set back.
bool StickControl::waited(std::uint32_t sent_ms, ano::TimePoint now, bool is_new) noexcept {
    constexpr ano::Duration forget = std::chrono::seconds{5};
    if (sent_ms == 0) return false;    // not stated
    const std::int64_t delay = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() -
                               std::int64_t{sent_ms};
    if (is_new && !old_since_) least_delay_ms_.reset();
    if (old_since_ && now - *old_since_ >= forget) {
        least_delay_ms_.reset();
        old_since_.reset();
    }
    least_delay_ms_ = std::min(least_delay_ms_.value_or(delay), delay);
    const bool is_old = delay - *least_delay_ms_ > std::chrono::duration_cast<std::chrono::milliseconds>(max_age).count();
    if (!is_old) old_since_.reset();
    else if (!old_since_) old_since_ = now;
    return is_old;
}

StickControl::Outcome StickControl::channels_of_sticks(PacketView packet) const noexcept {
    constexpr std::int16_t most = 1000;
    const auto m = *as<"MANUAL_CONTROL">(packet);
    const std::int16_t x = m.get<"x">(), y = m.get<"y">(), z = m.get<"z">(), r = m.get<"r">();
    const auto is_stick = [](std::int16_t value, std::int16_t least) { return value >= least && value <= most; };
    if (!is_stick(x, -most) || !is_stick(y, -most) || !is_stick(z, 0) || !is_stick(r, -most)) return StickFault::malformed;
    const auto channel = [](std::int16_t value) { return static_cast<std::int16_t>(1500 + value / 2); };
    ChannelFrame frame{{channel(y), channel(x), static_cast<std::int16_t>(1000 + z), channel(r)}};
    for (std::size_t i = 0; i < settings_.aux.size(); ++i) frame.channels[4 + i] = static_cast<std::int16_t>(settings_.aux[i]);
    return StickFrame{frame};
}

// A channel that is given back to the radio, or left as it is, can't be expressed: all ten are in one frame.
StickControl::Outcome StickControl::channels_of_override(PacketView packet) const noexcept {
    constexpr std::uint16_t least = 1000, most = 2000;
    const auto m = *as<"RC_CHANNELS_OVERRIDE">(packet);
    std::array all{m.get<"chan1_raw">(), m.get<"chan2_raw">(), m.get<"chan3_raw">(), m.get<"chan4_raw">(), m.get<"chan5_raw">(),
                   m.get<"chan6_raw">(), m.get<"chan7_raw">(), m.get<"chan8_raw">(), m.get<"chan9_raw">(), m.get<"chan10_raw">()};
    ChannelFrame frame;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (i >= 4 && (all[i] == 0 || all[i] >= 0xFFFE)) all[i] = settings_.aux[i - 4];
        if (all[i] < least || all[i] > most) return StickFault::malformed;
        frame.channels[i] = static_cast<std::int16_t>(all[i]);
    }
    return StickFrame{frame};
}

StickControl::Outcome StickControl::velocity_of(PacketView packet, ano::TimePoint now, const VehicleState& state) const noexcept {
    constexpr unsigned position = 7, velocity = 7u << 3, acceleration = 7u << 6, force = 1u << 9, yaw = 1u << 10,
                       yaw_rate = 1u << 11;
    constexpr std::uint8_t local_ned = 1, body_ned = 8, body_offset_ned = 9, body_frd = 12;
    const auto m = *as<"SET_POSITION_TARGET_LOCAL_NED">(packet);
    const unsigned ignored = m.get<"type_mask">();
    const bool is_velocity = (ignored & position) == position && (ignored & velocity) == 0 &&
                             (ignored & acceleration) == acceleration && (ignored & force) == 0 && (ignored & yaw) != 0;
    const double turning = (ignored & yaw_rate) != 0 ? 0.0 : double{m.get<"yaw_rate">()};
    double x = m.get<"vx">(), y = m.get<"vy">();
    const double z = m.get<"vz">();
    if (!is_velocity || !std::isfinite(x + y + z + turning)) return StickFault::malformed;
    if (const StickFault fault = mode_fault(state, settings_.velocity_modes, now); fault != StickFault::none) return fault;
    const std::uint8_t frame = m.get<"coordinate_frame">();
    if (frame == local_ned) {
        const ano::Rotation* const attitude = state.attitude(now);
        if (attitude == nullptr) return StickFault::malformed;
        const double heading = angles_of(*attitude).yaw, north = x, east = y;
        x = north * std::cos(heading) + east * std::sin(heading);
        y = east * std::cos(heading) - north * std::sin(heading);
    } else if (frame != body_ned && frame != body_offset_ned && frame != body_frd) {
        return StickFault::malformed;
    }
    return StickFrame{RealtimeFrame{0, 0, settings_.hover_throttle, yaw_rate_to_the_left(turning), centimetres(x),
                                    centimetres(-y), centimetres(-z)}};
}

StickControl::Outcome StickControl::attitude_of(PacketView packet, ano::TimePoint now, const VehicleState& state) const noexcept {
    constexpr unsigned yaw_rate = 4, thrust = 64, attitude = 128;
    const auto m = *as<"SET_ATTITUDE_TARGET">(packet);
    const unsigned ignored = m.get<"type_mask">();
    const auto q = ano::rotation_of_quaternion(m.get<"q">(0), m.get<"q">(1), m.get<"q">(2), m.get<"q">(3));
    const double turning = (ignored & yaw_rate) != 0 ? 0.0 : double{m.get<"body_yaw_rate">()};
    const double throttle = (ignored & thrust) != 0 ? settings_.hover_throttle : 100 * double{m.get<"thrust">()};
    if ((ignored & attitude) != 0 || !q || !std::isfinite(turning) || !(throttle >= 0 && throttle <= 100))
        return StickFault::malformed;
    if (const StickFault fault = mode_fault(state, settings_.attitude_modes, now); fault != StickFault::none) return fault;
    const Angles angles = angles_of(*q);
    const double sign = settings_.signs == ano::EulerSigns::lx ? 1 : -1;
    const auto lean = [](double degrees_of_lean) { return std::clamp(degrees_of_lean, -max_lean, max_lean); };
    return StickFrame{RealtimeFrame{lean(degree_per_radian * angles.roll), lean(sign * degree_per_radian * angles.pitch),
                                    throttle, yaw_rate_to_the_left(turning), 0, 0, 0}};
}

RealtimeFrame StickControl::stopped() const noexcept { return {0, 0, settings_.hover_throttle, 0, 0, 0, 0}; }

std::optional<ano::TimePoint> StickControl::due() const noexcept {
    return steering_ ? std::optional{used_at_ + silence} : std::nullopt;
}

std::optional<StickFrame> StickControl::on_time(ano::TimePoint now, const VehicleState& state) {
    if (!steering_ || now - used_at_ < silence) return std::nullopt;
    const auto& modes = *steering_ == StickInput::velocity ? settings_.velocity_modes : settings_.attitude_modes;
    steering_.reset();
    return mode_fault(state, modes, now) == StickFault::none ? std::optional{StickFrame{stopped()}} : std::nullopt;
}

std::optional<Origin> StickControl::station(ano::TimePoint now) const noexcept {
    return now - used_at_ < silence ? station_ : std::nullopt;
}

}    // namespace anogate::mavlink
