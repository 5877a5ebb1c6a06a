// The alarms and lost devices, for clients that follow them. Pure except for the clients that it wakes.
#pragma once
#include <devices/alarm_watch.hpp>
#include <devices/line_stream.hpp>
#include <devices/loss_watch.hpp>

#include <bitset>
#include <cstdint>
#include <optional>
#include <vector>

namespace anogate {

/// Without clients, values are judged when received, and nothing else is done. With clients, look() runs at most ten times a
/// second, and only while a value is beyond its limit or has just returned, or when a device may be lost or back.
class AlarmFeed {
public:
    static constexpr ano::Duration between_looks = std::chrono::milliseconds{100};
    /// Alarms are sent again after this time even if they are the same, since their times have changed. Lost devices too, but
    /// those that were locked only until `locked_reported_for`.
    static constexpr ano::Duration resend_interval = std::chrono::seconds{1};
    static constexpr ano::Duration locked_reported_for = std::chrono::minutes{1};
    /// A look() that is this late judges no device: the gateway was stalled, and frames of the devices may wait to be read.
    static constexpr ano::Duration too_late = std::chrono::milliseconds{500};

    const AlarmWatch& watch() const noexcept { return watch_; }
    LineClients& clients() noexcept { return clients_; }

    void set(std::uint8_t address, const AlarmLimits::List& limits, ano::TimePoint now);
    void forget(std::uint8_t address, ano::TimePoint now);
    /// See AlarmWatch::hear().
    void receive(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now, bool raises_only);

    /// Whether there are clients that still see this device as lost: then look_soon() must be called for its telemetry.
    bool awaits(std::uint8_t address) const noexcept { return !clients_.empty() && !sent_as_present_[address]; }
    void look_soon(ano::TimePoint now);

    /// When to call look(); std::nullopt: not needed.
    std::optional<ano::TimePoint> due() const noexcept { return due_; }
    /// Also to be called when a client joins. `devices`: all, by address.
    void look(std::vector<WatchedDevice> devices, ano::TimePoint now);

    /// The alarms at the last look(), as sent to all clients.
    const std::vector<ActiveAlarm>& sent_alarms() const noexcept { return sent_alarms_; }
    const std::vector<WatchedDevice>& sent_devices() const noexcept { return sent_devices_; }
    /// A number that differs after each change of the data sent, or of its times.
    std::uint64_t version() const noexcept { return version_; }

private:
    void look_at(ano::TimePoint at);

    AlarmWatch watch_;
    LineClients clients_;
    std::vector<ActiveAlarm> sent_alarms_;
    std::vector<WatchedDevice> sent_devices_;
    std::bitset<256> sent_as_present_;
    std::uint64_t version_ = 0;
    ano::TimePoint sent_at_{};
    std::optional<ano::TimePoint> due_;
};

}    // namespace anogate
