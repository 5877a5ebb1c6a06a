// When which message about a vehicle is sent to one ground station. Only numbers of messages wait, never values: a slow link gets the
// newest. No I/O, no clock.
#pragma once
#include <mavlink/telemetry.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace anogate::mavlink {

class TelemetrySchedule {
public:
    static constexpr ano::Duration least_interval = std::chrono::milliseconds{5};

    explicit TelemetrySchedule(ano::TimePoint now);

    /// SET_MESSAGE_INTERVAL. `interval_us`: microseconds; 0: the usual rate; -1: never. False: there is no such message.
    bool set_interval(std::uint32_t id, double interval_us, ano::TimePoint now) noexcept;
    /// REQUEST_DATA_STREAM. Stream 0: all. Rate 0 or `start` false: never. False: there is no such stream.
    bool set_stream(std::uint8_t stream, double rate, bool start, ano::TimePoint now) noexcept;
    /// MESSAGE_INTERVAL.interval_us: -1: never, 0: there is no such message.
    std::int32_t interval_us(std::uint32_t id) const noexcept;

    /// The place in telemetry_rows() of the message that is most overdue; std::nullopt: none is due. Call it whenever the link accepts a
    /// packet, and after frames were received. `is_fresh`: whether a message has new values; one that has none is left out. A message may be
    /// early by half of its interval, so that values that arrive at its rate are sent when they arrive.
    std::optional<std::size_t> next(
        ano::TimePoint now, const std::function<bool(std::size_t place)>& is_fresh = [](auto) { return true; }) const;
    /// It was sent.
    void on_sent(std::size_t place, ano::TimePoint now) noexcept;

private:
    struct Entry {
        ano::Duration interval{};    // zero: never
        ano::TimePoint due{};
    };
    static void set(Entry& entry, ano::Duration interval, ano::TimePoint now) noexcept;

    std::vector<Entry> entries_;    // as telemetry_rows()
};

}    // namespace anogate::mavlink
