// What is in alarm and which devices are lost, for those who follow it. Pure but for the clients that it wakes.
#pragma once
#include <devices/alarm_watch.hpp>
#include <devices/line_stream.hpp>
#include <devices/loss_watch.hpp>

#include <bitset>
#include <cstdint>
#include <optional>
#include <vector>

namespace anogate {

/// While nobody follows, values are judged as they come, and nothing else is done. While somebody follows, it looks at most ten times a
/// second, and only while a value is beyond its limit or has just come back, or when a device may be lost or back.
class AlarmFeed {
public:
    static constexpr ano::Duration between_looks = std::chrono::milliseconds{100};
    /// What is in alarm is told again after this time, though it is the same: its times have changed. So are lost devices, but for those
    /// that were locked, after `tells_locked`.
    static constexpr ano::Duration told_every = std::chrono::seconds{1};
    static constexpr ano::Duration tells_locked = std::chrono::minutes{1};
    /// A look that comes so much too late judges no device: the gateway stood still, and what they sent may wait to be read.
    static constexpr ano::Duration too_late = std::chrono::milliseconds{500};

    const AlarmWatch& watch() const noexcept { return watch_; }
    LineClients& clients() noexcept { return clients_; }

    void set(std::uint8_t address, const AlarmLimits::List& limits, ano::TimePoint now);
    void forget(std::uint8_t address, ano::TimePoint now);
    /// As AlarmWatch::hear().
    void hear(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now, bool raises_only);

    /// Whether there are clients who do not know that this device is heard: then look_soon() is to be called for its telemetry.
    bool awaits(std::uint8_t address) const noexcept { return !clients_.empty() && !told_as_heard_[address]; }
    void look_soon(ano::TimePoint now);

    /// When to call look(); std::nullopt: not needed.
    std::optional<ano::TimePoint> due() const noexcept { return due_; }
    /// Also to be called when a client joins. `devices`: all, by address.
    void look(std::vector<WatchedDevice> devices, ano::TimePoint now);

    /// What was in alarm at the last look(), which all clients are told.
    const std::vector<ActiveAlarm>& told() const noexcept { return told_; }
    const std::vector<WatchedDevice>& told_devices() const noexcept { return told_devices_; }
    /// Another number for each change of what is told, or of its times.
    std::uint64_t version() const noexcept { return version_; }

private:
    void look_at(ano::TimePoint at);

    AlarmWatch watch_;
    LineClients clients_;
    std::vector<ActiveAlarm> told_;
    std::vector<WatchedDevice> told_devices_;
    std::bitset<256> told_as_heard_;
    std::uint64_t version_ = 0;
    ano::TimePoint told_at_{};
    std::optional<ano::TimePoint> due_;
};

}    // namespace anogate
