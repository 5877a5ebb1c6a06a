// Sticks, velocities and attitudes of a ground station as 0x40 and 0x41. No I/O, no clock.
//
// One station at a time; nothing that waited for more than max_age; a vehicle whose station falls silent is stopped after `silence`.
// Nothing is invented: every channel is stated by the station or by the configuration, and the throttle is never 0 by omission.
#pragma once
#include <mavlink/packet.hpp>
#include <mavlink/vehicle_state.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate::mavlink {

/// Messages that control a vehicle, by the names by which the configuration allows them.
enum class StickInput : std::uint8_t { manual_control, rc_override, velocity, attitude };
inline constexpr std::string_view stick_input_names[] = {"manual_control", "rc_override", "velocity", "attitude"};

struct StickSettings {
    std::array<bool, 4> accepts{};                  // by StickInput
    double hover_throttle = 0;                      // %, for velocity and attitude
    std::vector<std::uint8_t> velocity_modes{2};    // flight modes (0x06) in which velocities are followed
    std::vector<std::uint8_t> attitude_modes{0};    // and attitudes
    std::array<std::uint16_t, 6> aux{};             // channels 5 to 10, unless the station states them; 0: not set
    ano::EulerSigns signs = ano::EulerSigns::document;

    bool accepts_input(StickInput input) const noexcept { return accepts[static_cast<std::size_t>(input)]; }
};

/// 0x40: roll, pitch, throttle, yaw, aux1 to aux6; 1000 to 2000.
struct ChannelFrame {
    std::array<std::int16_t, 10> channels{};
    bool operator==(const ChannelFrame&) const = default;
};
/// 0x41, in its units.
struct RealtimeFrame {
    double roll = 0, pitch = 0;          // °
    double throttle = 0;                 // %
    std::int16_t yaw_rate = 0;           // °/s, to the left
    std::int16_t x = 0, y = 0, z = 0;    // cm/s: forward, left, up
    bool operator==(const RealtimeFrame&) const = default;
};
using StickFrame = std::variant<ChannelFrame, RealtimeFrame>;

/// Why a message was not used.
enum class StickFault : std::uint8_t {
    none,
    not_sticks,       // another message
    not_allowed,      // by the configuration
    other_station,    // another station controls the vehicle
    old,              // it waited for more than StickControl::max_age
    malformed,        // values that can't be expressed
    wrong_mode,       // the flight mode does not follow it
    unknown_mode,     // the device did not report its mode lately
};
inline constexpr std::size_t stick_faults = 8;
std::string_view format_fault(StickFault fault) noexcept;

class StickControl {
public:
    static constexpr ano::Duration silence = std::chrono::milliseconds{500}, max_age = std::chrono::milliseconds{200};

    explicit StickControl(StickSettings settings) : settings_{std::move(settings)} {}

    /// `received_at`: when its bytes were received. StickFault::none: `frame` is to be sent.
    StickFault receive(PacketView packet, ano::TimePoint received_at, ano::TimePoint now, const VehicleState& state,
                       StickFrame& frame);
    /// The frame that stops the vehicle once after the last velocity or attitude, if the mode still follows it.
    std::optional<StickFrame> on_time(ano::TimePoint now, const VehicleState& state);
    std::optional<ano::TimePoint> due() const noexcept;
    /// The station that controls the vehicle.
    std::optional<Origin> station(ano::TimePoint now) const noexcept;

private:
    using Outcome = std::variant<StickFrame, StickFault>;
    Outcome channels_of_sticks(PacketView packet) const noexcept;
    Outcome channels_of_override(PacketView packet) const noexcept;
    Outcome velocity_of(PacketView packet, ano::TimePoint now, const VehicleState& state) const noexcept;
    Outcome attitude_of(PacketView packet, ano::TimePoint now, const VehicleState& state) const noexcept;
    bool waited(std::uint32_t sent_ms, ano::TimePoint now, bool is_new) noexcept;
    RealtimeFrame stopped() const noexcept;

    StickSettings settings_;
    std::optional<Origin> station_;
    ano::TimePoint used_at_{};
    std::optional<std::int64_t> least_delay_ms_;    // of the station's clock to ours
    std::optional<ano::TimePoint> old_since_;
    std::optional<StickInput> steering_;    // the vehicle has to be stopped; velocity or attitude
};

/// Reads its target; std::nullopt: it is not a message of a StickInput.
std::optional<StickInput> stick_input(PacketView packet, std::uint8_t& target_system) noexcept;

}    // namespace anogate::mavlink
