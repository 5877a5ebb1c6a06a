#include <ano/conversation.hpp>
#include <ano/typed.hpp>
#include <host/air_guard.hpp>

namespace ano::host {
namespace {

constexpr std::uint8_t locked = 0;

}    // namespace

void AirGuard::receive(FrameView frame, TimePoint now) noexcept {
    if (const auto mode = as<"mode">(frame)) devices_[frame.source()].in_the_air = mode->get<"sflag">() != locked;
    if (!writes(frame)) return;
    const auto is_written = [&](DeviceState& device) {
        device.writer = frame.source();
        device.written_at = now;
    };
    if (frame.destination() != address::broadcast) return is_written(devices_[frame.destination()]);
    for (DeviceState& device : devices_) is_written(device);
}

std::optional<std::uint8_t> AirGuard::other_writer(std::uint8_t address, TimePoint now) const noexcept {
    const DeviceState& device = devices_[address];
    if (device.writer == 0 || device.writer == address || now - device.written_at >= writes_for) return std::nullopt;
    return device.writer;
}

std::optional<Refusal> AirGuard::refusal(Operation operation, std::uint8_t address, RouteInfo where, bool force) const noexcept {
    if (address == address::broadcast || address == address::unassigned || address::is_host(address)) return Refusal::no_device;
    if (operation != Operation::ground) return std::nullopt;
    if (!where.is_known) return Refusal::not_known;
    if (where.in_conflict) return Refusal::in_conflict;
    if (where.on_several_channels) return Refusal::on_several_channels;
    if (is_in_the_air(address) && !force) return Refusal::in_the_air;
    return std::nullopt;
}

}    // namespace ano::host
