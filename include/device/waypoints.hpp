// The waypoints of a device (protocol text, section 4, 0x60 and 0x61).
#pragma once
#include <ano/typed.hpp>
#include <device/reply.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace ano::device {

struct Waypoint {
    double lng = 0, lat = 0;    // °, in steps of 1e-7
    std::int32_t alt = 0;       // cm
    std::uint16_t spd = 0;      // cm/s
    std::uint16_t yaw = 0;      // 0 to 359 ° from north; 400: face the target
    std::uint8_t fun = 0;
    std::array<std::uint8_t, 4> cmd{};
    friend bool operator==(const Waypoint&, const Waypoint&) = default;
};

/// Number 0 is HOME. Hosts write them in order from 0; writing the number after the last one appends a waypoint.
class Waypoints {
public:
    /// A count of 255 can't be reported: the byte 255 in a 0x60 asks for the count.
    static constexpr std::size_t max_waypoints = 254;

    /// Sets the maximum number of waypoints, at most `max_waypoints`. 0, the initial value: the device has no waypoints and does
    /// not answer questions about them.
    void allow(std::size_t count);
    /// `may` is called before a waypoint is stored; false: refused, and not acknowledged.
    void on_write(std::function<bool(std::size_t number, const Waypoint&)> may) { may_ = std::move(may); }

    std::size_t count() const noexcept { return list_.size(); }
    const Waypoint& operator[](std::size_t number) const noexcept { return list_[number]; }
    /// For the program itself: keeps the first `count` waypoints, at most the allowed number; new ones are all 0.
    void resize(std::size_t count) { list_.resize(count < allowed_ ? count : allowed_); }
    void set(std::size_t number, const Waypoint& waypoint) noexcept { list_[number] = waypoint; }

    Outcome process(const View<"waypoint_read">& question, Reply& reply) const;
    /// Answers 0x61, which to a device is always a write.
    Outcome process(const View<"waypoint">& written, Reply& reply);

private:
    std::vector<Waypoint> list_;
    std::size_t allowed_ = 0;
    std::function<bool(std::size_t, const Waypoint&)> may_;
};

}    // namespace ano::device
