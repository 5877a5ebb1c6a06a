// Compares the values of devices with their alarm limits. Pure: the owner supplies the frames and the time.
//
// Flow:    watch.set(device, limits, now);
//          if (watch.wants(source, id)) watch.hear(source, ano::read(frame, layouts), now);
//          for (const ActiveAlarm& alarm : watch.active(now)) show(alarm);
#pragma once
#include <ano/reading.hpp>
#include <ano/time.hpp>
#include <devices/alarm_limits.hpp>

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace anogate {

enum class AlarmLevel : std::uint8_t { none, amber, red };
std::string_view text(AlarmLevel level) noexcept;

/// Judged by the value alone; `value` is divided by the cells of the limit.
AlarmLevel level_of(double value, const AlarmLimit& limit) noexcept;

/// Measures how long one value has been beyond its limit. If the value is not received any more, its state does not change.
class LimitClock {
public:
    /// `value`: in the unit of the message table.
    void update(double value, const AlarmLimit& limit, ano::TimePoint now) noexcept;
    /// The limit was changed: judges the last value again.
    void judge(const AlarmLimit& limit, ano::TimePoint now) noexcept;

    /// `red` once the value has been beyond `limit.red` for `limit.for_s`; likewise for amber.
    AlarmLevel level(const AlarmLimit& limit, ano::TimePoint now) const noexcept;
    /// Whether it is beyond a limit, for any time.
    bool is_beyond() const noexcept { return amber_since_.has_value(); }
    /// The level whose edge the last value is beyond.
    AlarmLevel edge() const noexcept {
        return red_since_ ? AlarmLevel::red : amber_since_ ? AlarmLevel::amber : AlarmLevel::none;
    }
    /// The time since which the value is beyond the edge of `level`; only while level() is at least that.
    ano::TimePoint since(AlarmLevel level) const noexcept { return level == AlarmLevel::red ? *red_since_ : *amber_since_; }
    double value() const noexcept { return value_; }
    /// When the last value was received; std::nullopt: none yet.
    std::optional<ano::TimePoint> heard_at() const noexcept { return heard_at_; }

private:
    double value_ = 0;
    std::optional<ano::TimePoint> heard_at_, amber_since_, red_since_;
};

/// A value that is beyond its limit for long enough.
struct ActiveAlarm {
    std::uint8_t device = 0;
    AlarmLimit limit;
    AlarmLevel level = AlarmLevel::none;
    double value = 0;    // divided by the cells of the limit
    ano::TimePoint since{};
    ano::TimePoint heard_at{};    // when its last value was received

    /// Equal except for the times.
    bool is_same(const ActiveAlarm& other) const noexcept {
        return device == other.device && limit == other.limit && level == other.level && value == other.value;
    }
};

/// Memory: at most AlarmLimits::max_limits clocks per device, none for a device without limits.
class AlarmWatch {
public:
    /// Replaces the limits of a device. The state of a value is kept if its field and side have a limit again. A host has no
    /// alarms.
    void set(std::uint8_t address, const AlarmLimits::List& limits, ano::TimePoint now);
    /// Discards the values of a device: none of them is in alarm until it is received again.
    void forget(std::uint8_t address) noexcept;

    /// Whether frames of this message have a value with a limit. Other messages need neither be decoded nor passed to hear().
    bool wants(std::uint8_t source, std::uint8_t id) const noexcept { return watched_[source] && watched_[source]->ids[id]; }
    /// Ignores frames that can't be decoded, "no data", and fields that are not one number. True: one of its values is beyond its
    /// limit, or was until now. `raises_only`: the frame is not known to be from the device itself, so a value that is better
    /// than the last one is ignored.
    bool receive(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now, bool raises_only = false) noexcept;

    /// Red ones first, then ordered by device and by its limits.
    std::vector<ActiveAlarm> active(ano::TimePoint now) const;
    /// Whether any value is beyond its limit, for any time.
    bool any_beyond() const noexcept;

private:
    struct Watched {
        struct Value {
            AlarmLimit limit;
            std::optional<std::uint8_t> id;    // of its message; std::nullopt: the table has none of this name
            LimitClock clock;
        };
        std::bitset<256> ids;
        std::vector<Value> values;
    };
    std::array<std::unique_ptr<Watched>, 256> watched_;
};

}    // namespace anogate
