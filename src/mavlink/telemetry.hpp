// Messages about a vehicle, from the latest values of its device. No I/O, no clock.
#pragma once
#include <mavlink/flight_modes.hpp>
#include <mavlink/typed.hpp>
#include <mavlink/vehicle_state.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::mavlink {

/// A message without its packet.
struct Payload {
    const Message* row = nullptr;
    std::array<std::uint8_t, max_payload> bytes{};

    Payload() = default;
    template <ano::Name M>
    Payload(const Draft<M>& draft) noexcept : row{&Draft<M>::row} {
        std::copy(draft.payload().begin(), draft.payload().end(), bytes.begin());
    }
    std::span<const std::uint8_t> payload() const noexcept { return {bytes.data(), row->size}; }
};

/// A command that takes a while, as 0x06 shows it.
struct ActivityCommand {
    Cid cid{};
    Activity activity = Activity::hold;
    bool operator==(const ActivityCommand&) const = default;
};

struct VehicleIdentity {
    Autopilot autopilot = Autopilot::generic;
    std::uint8_t type = 2;                       // MAV_TYPE; 2: quadrotor
    std::uint8_t cells = 0;                      // of the battery; 0: unknown
    std::vector<ActivityCommand> activities;     // commands in 0x06
    std::uint16_t hardware = 0, software = 0;    // versions in 0xE3
    bool has_missions = false, has_attitude_target = false, has_velocity_target = false;
};

/// Counters of one link to a ground station.
struct LinkCounters {
    std::uint64_t sent = 0, received = 0, lost = 0, bad = 0;    // packets
    std::uint32_t sent_rate = 0, received_rate = 0;             // bytes/s
};

struct TelemetryContext {
    const VehicleState& state;
    const VehicleIdentity& identity;
    const LinkCounters& link;
    ano::TimePoint now{};
    std::uint64_t since_start_us = 0;
    std::uint64_t unix_us = 0;
};

/// What the vehicle does, by its last 0x06; std::nullopt: it is not known.
std::optional<Activity> activity_of(const TelemetryContext& context) noexcept;

/// The groups of REQUEST_DATA_STREAM.
enum class Stream : std::uint8_t {
    none,
    raw_sensors,
    extended_status,
    rc_channels,
    raw_controller = 4,
    position = 6,
    extra1 = 10,
    extra2,
    extra3
};

struct TelemetryRow {
    std::uint32_t id;
    double rate;    // Hz, unless a station requests another
    Stream stream;
    /// std::nullopt: the values are not known, or too old.
    std::optional<Payload> (*make)(const TelemetryContext& context);
    /// The frames that its main values come from; 0x00: none. It is sent again only after another of these.
    std::array<std::uint8_t, 2> sources{};

    bool has_sources() const noexcept { return sources[0] != 0; }
    /// Changes with every such frame.
    std::uint32_t version(const VehicleState& state) const noexcept {
        return state.frames(sources[0]) + state.frames(sources[1]);
    }
};
std::span<const TelemetryRow> telemetry_rows() noexcept;
/// nullptr: there is no such message.
const TelemetryRow* find_telemetry(std::uint32_t id) noexcept;

/// MAV_SEVERITY.
enum class Severity : std::uint8_t { emergency, alert, critical, error, warning, notice, info, debug };

/// STATUSTEXT of a text in UTF-8, in as many parts as it needs, each of whole characters. `id`: of the text, not 0, if it has several.
std::vector<Payload> status_texts(Severity severity, std::string_view text, std::uint16_t id);

/// The values of a flexible message: NAMED_VALUE_FLOAT for each number, DEBUG_FLOAT_ARRAY for each array.
std::vector<Payload> named_values(const ano::Reading& reading, std::uint64_t since_start_us);

}    // namespace anogate::mavlink
