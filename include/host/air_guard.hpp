// Actions that are not allowed on a device now, because it is in the air or its address is not that of one known device; and
// which other host writes to it.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace ano::host {

enum class Operation : std::uint8_t {
    read,
    write,    // parameters, waypoints, commands, save
    ground    // upgrade, calibration, restore_defaults: never in the air
};

/// The router's data about the address.
struct RouteInfo {
    bool is_known = false;               // a frame from it was received, so that a frame to it is not flooded
    bool in_conflict = false;            // two devices use it
    bool on_several_channels = false;    // channels that are not of one group
    bool was_heard = false;              // at any time: a command is sent to the link of its last frame, if that is up
};

enum class Refusal : std::uint8_t {
    no_device,    // broadcast, or an address that no device can have
    not_known,
    in_conflict,
    on_several_channels,
    in_the_air,    // unlocked or airborne; may be forced
};

/// Observes the traffic: hear() is called with every frame except those of this host. Does not allocate.
///
/// Writes of another host never cause a refusal: any program on a link can send one, with any source address. They are only
/// reported.
class AirGuard {
public:
    /// A host counts as writing to a device for this long after its last write.
    static constexpr Duration writes_for = std::chrono::seconds{2};

    void receive(FrameView frame, TimePoint now) noexcept;

    /// The reason why `operation` is not allowed on `address`; std::nullopt: it is allowed. `force` only overrides `in_the_air`.
    std::optional<Refusal> refusal(Operation operation, std::uint8_t address, RouteInfo where, bool force = false) const noexcept;

    /// By its last 0x06, however old: a device that stopped sending in the air may still be flying.
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
