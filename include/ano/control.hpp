// Which frames command a vehicle, and which may be acknowledged: two columns of the message table, by id.
#pragma once
#include <ano/frame.hpp>
#include <ano/messages.hpp>

#include <array>
#include <cstdint>

namespace ano {
namespace table {

consteval std::array<Controls, 256> controls_by_id() {
    std::array<Controls, 256> all{};
    for (const Message& row : messages)
        if (row.is_base()) all[row.id] = row.controls;
    return all;
}
inline constexpr std::array<Controls, 256> controls_of = controls_by_id();

consteval std::array<bool, 256> acknowledged_by_id() {
    std::array<bool, 256> all{};
    for (const Message& row : messages) all[row.id] = all[row.id] || row.acknowledged != Acknowledged::no;
    return all;
}
inline constexpr std::array<bool, 256> acknowledged = acknowledged_by_id();

}    // namespace table

/// A frame that commands or changes a vehicle (protocol text, sections 3 and 4): remote and realtime control, a command, a
/// parameter or waypoint written, firmware, and 0xE0 unless it is one of the listed questions: any other 0xE0 is an action,
/// whether it is listed or not.
constexpr bool is_control(FrameView frame) noexcept {
    const Controls controls = table::controls_of[frame.id()];
    if (controls != Controls::unless_listed) return controls == Controls::yes;
    return frame.data().empty() || find_message(frame.id())->fields().front().meaning(frame.data()[0]).empty();
}

/// A device may answer frames of this id with a check frame (0x00), which repeats their check bytes.
constexpr bool may_be_acknowledged(std::uint8_t id) noexcept { return table::acknowledged[id]; }

}    // namespace ano
