// What may not be done to a device now, because it is in the air or its address is not that of one known device; and which other host
// writes to it.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace ano::host {

enum class Deed : std::uint8_t {
    read,
    write,    // parameters, waypoints, commands, save
    ground    // upgrade, calibration, restore_defaults: never in the air
};

/// What the router knows about the address.
struct Whereabouts {
    bool is_known = false;               // it was heard, so that a frame to it is not flooded
    bool in_conflict = false;            // two devices use it
    bool on_several_channels = false;    // channels that are not of one group
    bool was_heard = false;              // however long ago: a command goes where that was last, by a link that is up
};

enum class Refusal : std::uint8_t {
    no_device,    // broadcast, or an address that no device may have
    not_known,
    in_conflict,
    on_several_channels,
    in_the_air,    // unlocked or airborne; may be forced
};

/// Observes the traffic: hear() is called with every frame except those of this host. No allocation.
///
/// A write of another host refuses nothing: anybody who reaches a link can send one, in anybody's name. It is only told.
class AirGuard {
public:
    /// A host counts as writing to a device for this long after its last write.
    static constexpr Duration writes_for = std::chrono::seconds{2};

    void hear(FrameView frame, TimePoint now) noexcept;

    /// Why `deed` may not be done to `address`; std::nullopt: it may. `force` only overrides `in_the_air`.
    std::optional<Refusal> refusal(Deed deed, std::uint8_t address, Whereabouts where, bool force = false) const noexcept;

    /// By its last 0x06, however long ago: a device that fell silent in the air may still be flying.
    bool is_in_the_air(std::uint8_t address) const noexcept { return devices_[address].in_the_air; }
    /// The address of the other host that writes to it; std::nullopt: none.
    std::optional<std::uint8_t> other_writer(std::uint8_t address, TimePoint now) const noexcept;

private:
    struct DeviceState {
        bool in_the_air = false;
        std::uint8_t writer = 0;    // 0: none
        TimePoint written_at{};
    };
    std::array<DeviceState, 256> devices_{};
};

}    // namespace ano::host
