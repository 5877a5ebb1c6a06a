// Missions of ground stations as waypoints of a device (0x61), and back. No I/O, no clock.
#pragma once
#include <host/waypoints.hpp>
#include <mavlink/flight_modes.hpp>
#include <mavlink/typed.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate::mavlink {

using Waypoint = ano::host::Waypoint;

/// MAV_MISSION_RESULT.
enum class MissionResult : std::uint8_t {
    accepted,
    error,
    unsupported_frame,
    unsupported,
    no_space,
    invalid,
    invalid_parameter_1,
    invalid_parameter_2,
    invalid_parameter_3,
    invalid_parameter_4,
    invalid_latitude,
    invalid_longitude,
    invalid_altitude,
    invalid_sequence,
    denied,
    cancelled,
};

struct MissionItem {
    std::uint8_t frame = 3;    // MAV_FRAME
    std::uint16_t command = 16;
    std::array<float, 4> parameters{};
    std::int32_t lat = 0, lng = 0;    // 1e-7 degrees
    float altitude = 0;               // m
    bool operator==(const MissionItem&) const = default;
};
/// Of MISSION_ITEM_INT and MISSION_ITEM.
std::optional<MissionItem> mission_item(PacketView packet, std::uint16_t& number) noexcept;

/// The kinds of items that a device may know, as values of `fun`.
enum class ItemKind : std::uint8_t { waypoint, hold, take_off, land, return_home };
inline constexpr std::string_view item_kind_names[] = {"waypoint", "hold", "take_off", "land", "return_home"};

/// One byte of cmd1 to cmd4: a constant, or the time of a hold in seconds.
struct ItemByte {
    bool is_hold_time = false;
    std::uint8_t constant = 0;
    bool operator==(const ItemByte&) const = default;
};
/// A row of the table of the configuration: what `fun` means to the device.
struct FunRow {
    ItemKind kind{};
    std::uint8_t fun = 0;
    std::array<ItemByte, 4> bytes{};
    bool operator==(const FunRow&) const = default;
};
/// As sim:fc: 0 passes, 1 stays cmd1 seconds.
std::vector<FunRow> usual_funs();

/// Why a mission is refused: the item, and the reason for people.
struct MissionRefusal {
    MissionResult result{};
    std::size_t item = 0;
    std::string text{};
};

struct MissionContext {
    std::span<const FunRow> funs;
    Waypoint home{};                          // of the device
    std::optional<double> home_altitude{};    // m, above sea level
};

/// Waypoints from 1 on. Speed changes (178) become the speeds of the waypoints after them.
std::variant<std::vector<Waypoint>, MissionRefusal> waypoints_of(std::span<const MissionItem> items,
                                                                 const MissionContext& context);
/// The items of `waypoints`, without HOME.
std::vector<MissionItem> items_of(std::span<const Waypoint> waypoints, std::span<const FunRow> funs);
/// The waypoint that the item becomes.
std::uint8_t waypoint_of_item(std::span<const MissionItem> items, std::size_t item) noexcept;

}    // namespace anogate::mavlink
