#include <mavlink/flight_modes.hpp>

#include <iterator>

namespace anogate::mavlink {
namespace {

constexpr std::uint32_t px4(std::uint32_t main, std::uint32_t sub = 0) noexcept { return main << 16 | sub << 24; }

// The numbers of PX4 (main and sub mode) and of ArduCopter. For an autopilot of no kind, ours.
struct ModeRow {
    Activity activity;
    std::uint32_t px4, ardupilot, generic;
};
constexpr ModeRow mode_rows[] = {
    {Activity::attitude, px4(7), 0, 0},          // Stabilized; Stabilize
    {Activity::height, px4(2), 2, 1},            // Altitude; AltHold
    {Activity::position, px4(3), 16, 2},         // Position; PosHold
    {Activity::programmed, px4(4, 3), 4, 3},     // Hold; Guided
    {Activity::take_off, px4(4, 2), 4, 4},       // Takeoff; Guided
    {Activity::land, px4(4, 6), 9, 5},           // Land; Land
    {Activity::return_home, px4(4, 5), 6, 6},    // Return; RTL
    {Activity::go_to, px4(4, 3), 4, 7},          // Hold; Guided
    {Activity::mission, px4(4, 4), 3, 8},        // Mission; Auto
    {Activity::hold, px4(4, 3), 5, 9},           // Hold; Loiter
};

std::uint32_t number_in(const ModeRow& row, Autopilot autopilot) noexcept {
    if (autopilot == Autopilot::px4) return row.px4;
    return autopilot == Autopilot::ardupilot ? row.ardupilot : row.generic;
}

}    // namespace

std::uint8_t number_of(Autopilot autopilot) noexcept {
    constexpr std::uint8_t numbers[] = {0, 12, 3};
    return numbers[static_cast<std::size_t>(autopilot)];
}

std::uint32_t custom_mode(Autopilot autopilot, Activity activity) noexcept {
    for (const ModeRow& row : mode_rows)
        if (row.activity == activity) return number_in(row, autopilot);
    return 0;
}

std::optional<Activity> activity_of(Autopilot autopilot, std::uint32_t custom_mode) noexcept {
    // Several activities may have one number: a station that selects it wants the vehicle to stay where it is, or to fly by commands.
    if (autopilot == Autopilot::px4 && custom_mode == px4(4, 3)) return Activity::hold;
    for (const ModeRow& row : mode_rows)
        if (number_in(row, autopilot) == custom_mode) return row.activity;
    return std::nullopt;
}

}    // namespace anogate::mavlink
