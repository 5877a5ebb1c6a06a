#include <mavlink/telemetry_schedule.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace anogate::mavlink {
namespace {

constexpr ano::Duration never{};

ano::Duration interval_of(double rate) noexcept {
    if (!(rate > 0)) return never;
    return std::chrono::duration_cast<ano::Duration>(std::chrono::duration<double>{1 / rate});
}

}    // namespace

TelemetrySchedule::TelemetrySchedule(ano::TimePoint now) : entries_(telemetry_rows().size()) {
    for (std::size_t i = 0; i < entries_.size(); ++i) set(entries_[i], interval_of(telemetry_rows()[i].rate), now);
}

void TelemetrySchedule::set(Entry& entry, ano::Duration interval, ano::TimePoint now) noexcept {
    entry.interval = interval == never ? never : std::max(interval, least_interval);
    entry.due = now;
}

bool TelemetrySchedule::set_interval(std::uint32_t id, double interval_us, ano::TimePoint now) noexcept {
    constexpr double longest = 3.6e9;    // an hour
    bool found = false;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        const TelemetryRow& row = telemetry_rows()[i];
        if (row.id != id || std::isnan(interval_us)) continue;
        found = true;
        if (interval_us == 0) set(entries_[i], interval_of(row.rate), now);
        else if (interval_us < 0) set(entries_[i], never, now);
        else set(entries_[i], interval_of(1e6 / std::min(interval_us, longest)), now);
    }
    return found;
}

// HEARTBEAT belongs to no stream: without it, a vehicle is lost.
bool TelemetrySchedule::set_stream(std::uint8_t stream, double rate, bool start, ano::TimePoint now) noexcept {
    bool found = false;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        const auto of_row = static_cast<std::uint8_t>(telemetry_rows()[i].stream);
        if (of_row == 0 || (stream != 0 && stream != of_row)) continue;
        found = true;
        set(entries_[i], start ? interval_of(rate) : never, now);
    }
    return found;
}

std::int32_t TelemetrySchedule::interval_us(std::uint32_t id) const noexcept {
    for (std::size_t i = 0; i < entries_.size(); ++i)
        if (telemetry_rows()[i].id == id) {
            const auto us = std::chrono::duration_cast<std::chrono::microseconds>(entries_[i].interval).count();
            return us == 0 ? -1 : static_cast<std::int32_t>(std::min<std::int64_t>(us, std::numeric_limits<std::int32_t>::max()));
        }
    return 0;
}

std::optional<std::size_t> TelemetrySchedule::next(ano::TimePoint now,
                                                   const std::function<bool(std::size_t place)>& is_fresh) const {
    constexpr int early = 2;
    std::optional<std::size_t> most;
    double most_overdue = 0;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        const Entry& entry = entries_[i];
        if (entry.interval == never || entry.due - entry.interval / early > now) continue;
        // In intervals, so that a link that is too slow sends each message at the same share of its rate.
        const double overdue = std::chrono::duration<double>(now - entry.due) / std::chrono::duration<double>(entry.interval);
        if ((most && overdue <= most_overdue) || !is_fresh(i)) continue;
        most = i;
        most_overdue = overdue;
    }
    return most;
}

// What a slow link missed is not made up for.
void TelemetrySchedule::on_sent(std::size_t place, ano::TimePoint now) noexcept {
    Entry& entry = entries_[place];
    entry.due = now - entry.due > entry.interval ? now + entry.interval : entry.due + entry.interval;
}

}    // namespace anogate::mavlink
