#include <gateway/attitude_watch.hpp>

namespace anogate {
namespace {

constexpr ano::EulerSigns other_of(ano::EulerSigns signs) noexcept {
    return signs == ano::EulerSigns::lx ? ano::EulerSigns::document : ano::EulerSigns::lx;
}

}    // namespace

AttitudeWatch::Device* AttitudeWatch::device(std::uint8_t address, TimePoint now) noexcept {
    Device* unused = nullptr;
    for (Device& device : devices_) {
        if (device.address != 0 && now - device.heard_at >= forgotten) device = {};
        if (device.address == address) return &device;
        if (device.address == 0 && unused == nullptr) unused = &device;
    }
    if (unused != nullptr) unused->address = address;
    return unused;
}

void AttitudeWatch::receive(ano::FrameView frame, TimePoint now) noexcept {
    Device* const from = frame.source() == 0 ? nullptr : device(frame.source(), now);
    if (from == nullptr) return;
    from->heard_at = now;
    const auto rotation = ano::rotation_of(frame, signs_);
    const auto otherwise = ano::rotation_of(frame, other_of(signs_));
    if (!rotation || !otherwise) return;
    const bool is_euler = frame.id() == ano::id_of<"euler">;
    if (is_euler) from->by_other_signs = *otherwise;
    (is_euler ? from->by_euler : from->by_quaternion) = *rotation;
    (is_euler ? from->euler_at : from->quaternion_at) = now;
    if (from->euler_at && from->quaternion_at && now - *from->euler_at <= together && now - *from->quaternion_at <= together)
        compare(*from, now);
}

void AttitudeWatch::compare(Device& device, TimePoint now) noexcept {
    const auto agrees = [&](const ano::Rotation& euler) { return ano::degrees_between(euler, device.by_quaternion) <= apart; };
    if (!agrees(device.by_euler)) {
        device.agree_since.reset();
        if (!agrees(device.by_other_signs)) return device.apart_since.reset();
        if (!device.apart_since) device.apart_since = now;
        if (now - *device.apart_since >= patience) device.is_contradictory = true;
    } else {
        device.apart_since.reset();
        if (!device.agree_since) device.agree_since = now;
        if (now - *device.agree_since >= patience) device.is_contradictory = false;
    }
}

std::uint8_t AttitudeWatch::contradictory() const noexcept {
    for (const Device& device : devices_)
        if (device.is_contradictory) return device.address;
    return 0;
}

}    // namespace anogate
