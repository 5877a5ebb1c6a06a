// Compares the Euler angles (0x03) of devices with their quaternions (0x04). Finds devices whose signs differ from the setting.
#pragma once
#include <ano/attitude.hpp>
#include <ano/frame.hpp>
#include <ano/messages.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace anogate {

/// For one link. Constant time, no allocation. A few devices are compared; one that sends nothing for `forgotten`
/// makes room for others. A difference counts as a contradiction
/// only if both agree under the other signs. This excludes differences by a fast turn or by a quaternion of another kind.
class AttitudeWatch {
public:
    using Duration = ano::Duration;
    using TimePoint = ano::TimePoint;

    static constexpr double apart = 10;                                     // degrees: more is a contradiction
    static constexpr Duration patience = std::chrono::seconds{2};           // a contradiction begins and ends after this time
    static constexpr Duration together = std::chrono::milliseconds{100};    // both frames arrived within this time
    static constexpr Duration forgotten = std::chrono::seconds{10};
    static constexpr std::size_t max_devices = 4;

    explicit AttitudeWatch(ano::EulerSigns signs = ano::EulerSigns::document) noexcept : signs_{signs} {}

    static constexpr bool concerns(std::uint8_t id) noexcept {
        return id == ano::id_of<"euler"> || id == ano::id_of<"quaternion">;
    }
    /// `frame` is one for which concerns() is true, with the address of its device.
    void receive(ano::FrameView frame, TimePoint now) noexcept;

    /// A device whose frames contradict each other; 0: none.
    std::uint8_t contradictory() const noexcept;
    /// The setting during the comparison.
    ano::EulerSigns signs() const noexcept { return signs_; }

private:
    struct Device {
        std::uint8_t address = 0;    // 0: unused
        bool is_contradictory = false;
        ano::Rotation by_euler, by_other_signs, by_quaternion;
        std::optional<TimePoint> euler_at, quaternion_at;
        std::optional<TimePoint> apart_since, agree_since;
        TimePoint heard_at{};
    };
    Device* device(std::uint8_t address, TimePoint now) noexcept;
    static void compare(Device& device, TimePoint now) noexcept;

    ano::EulerSigns signs_;
    std::array<Device, max_devices> devices_{};
};

}    // namespace anogate
