// What is in alarm, for those who follow it. Pure but for the clients that it wakes.
#pragma once
#include <devices/alarm_watch.hpp>
#include <devices/line_stream.hpp>

#include <cstdint>
#include <optional>
#include <vector>

namespace anogate {

/// While nobody follows, values are judged as they come, and nothing else is done. While somebody follows, it looks at most ten times a
/// second, and only while a value is beyond its limit or has just come back.
class AlarmFeed {
public:
    static constexpr ano::Duration between_looks = std::chrono::milliseconds{100};
    /// What is in alarm is told again after this time, though it is the same: its times have changed.
    static constexpr ano::Duration told_every = std::chrono::seconds{1};

    const AlarmWatch& watch() const noexcept { return watch_; }
    LineClients& clients() noexcept { return clients_; }

    void set(std::uint8_t address, const AlarmLimits::List& limits, ano::TimePoint now);
    void forget(std::uint8_t address, ano::TimePoint now);
    /// As AlarmWatch::hear().
    void hear(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now);

    /// When to call look(); std::nullopt: not needed.
    std::optional<ano::TimePoint> due() const noexcept { return due_; }
    /// Also to be called when a client joins.
    void look(ano::TimePoint now);

    /// What was in alarm at the last look(), which all clients are told.
    const std::vector<ActiveAlarm>& told() const noexcept { return told_; }
    /// Another number for each change of told(), or of its times.
    std::uint64_t version() const noexcept { return version_; }

private:
    void look_soon(ano::TimePoint now);

    AlarmWatch watch_;
    LineClients clients_;
    std::vector<ActiveAlarm> told_;
    std::uint64_t version_ = 0;
    ano::TimePoint told_at_{};
    std::optional<ano::TimePoint> due_;
};

}    // namespace anogate
