#include <ano/address.hpp>
#include <devices/alarm_watch.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace anogate {
namespace {

ano::Duration for_time(const AlarmLimit& limit) noexcept {
    return std::chrono::duration_cast<ano::Duration>(std::chrono::duration<double>(limit.for_s));
}

std::string_view message_of(const AlarmLimit& limit) noexcept {
    return std::string_view{limit.field}.substr(0, limit.field.find('.'));
}
std::string_view field_of(const AlarmLimit& limit) noexcept {
    return std::string_view{limit.field}.substr(limit.field.find('.') + 1);
}

std::optional<std::uint8_t> id_of_message(std::string_view name) noexcept {
    const ano::Message* const row = ano::find_message(name);
    return row != nullptr ? std::optional{row->id} : std::nullopt;
}

double divided(double value, const AlarmLimit& limit) noexcept { return value / limit.cells.value_or(1); }

}    // namespace

std::string_view text(AlarmLevel level) noexcept {
    constexpr std::string_view texts[]{"none", "amber", "red"};
    return texts[static_cast<std::size_t>(level)];
}

AlarmLevel level_of(double value, const AlarmLimit& limit) noexcept {
    const auto is_beyond = [&](const std::optional<double>& edge) {
        return edge && (limit.is_below ? value < *edge : value > *edge);
    };
    if (is_beyond(limit.red)) return AlarmLevel::red;
    return is_beyond(limit.amber) ? AlarmLevel::amber : AlarmLevel::none;
}

void LimitClock::update(double value, const AlarmLimit& limit, ano::TimePoint now) noexcept {
    value_ = value;
    heard_at_ = now;
    judge(limit, now);
}

void LimitClock::judge(const AlarmLimit& limit, ano::TimePoint now) noexcept {
    const AlarmLevel level = heard_at_ ? level_of(divided(value_, limit), limit) : AlarmLevel::none;
    const auto keep = [now](std::optional<ano::TimePoint>& since, bool is_beyond) {
        if (!is_beyond) since.reset();
        else if (!since) since = now;
    };
    keep(red_since_, level == AlarmLevel::red);
    keep(amber_since_, level != AlarmLevel::none);
}

AlarmLevel LimitClock::level(const AlarmLimit& limit, ano::TimePoint now) const noexcept {
    const auto is_held = [&](const std::optional<ano::TimePoint>& since) { return since && now - *since >= for_time(limit); };
    if (is_held(red_since_)) return AlarmLevel::red;
    return is_held(amber_since_) ? AlarmLevel::amber : AlarmLevel::none;
}

void AlarmWatch::set(std::uint8_t address, const AlarmLimits::List& limits, ano::TimePoint now) {
    const std::unique_ptr<Watched> before = std::move(watched_[address]);
    if (limits.empty() || ano::address::is_host(address)) return;
    auto watched = std::make_unique<Watched>();
    for (const AlarmLimit& limit : limits) {
        auto& value = watched->values.emplace_back(Watched::Value{limit, id_of_message(message_of(limit)), {}});
        if (value.id) watched->ids.set(*value.id);
        if (!before) continue;
        for (const auto& old : before->values)
            if (old.limit.field == limit.field && old.limit.is_below == limit.is_below) value.clock = old.clock;
        value.clock.judge(limit, now);
    }
    watched_[address] = std::move(watched);
}

void AlarmWatch::forget(std::uint8_t address) noexcept {
    if (!watched_[address]) return;
    for (auto& value : watched_[address]->values) value.clock = {};
}

bool AlarmWatch::receive(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now, bool raises_only) noexcept {
    if (!reading || !watched_[source]) return false;
    bool concerns_alarms = false;
    for (auto& value : watched_[source]->values) {
        if (value.id != reading.message()->id) continue;
        const ano::Field* const field = reading.field(field_of(value.limit));
        if (field == nullptr || !ano::is_number(field->type) || field->count != 1) continue;
        const double number = reading.number(*field);
        if (!std::isfinite(number)) continue;
        const AlarmLevel level = level_of(divided(number, value.limit), value.limit);
        if (raises_only && (level == AlarmLevel::none || level < value.clock.edge())) continue;
        const bool was_beyond = value.clock.is_beyond();
        value.clock.update(number, value.limit, now);
        concerns_alarms = concerns_alarms || was_beyond || value.clock.is_beyond();
    }
    return concerns_alarms;
}

std::vector<ActiveAlarm> AlarmWatch::active(ano::TimePoint now) const {
    std::vector<ActiveAlarm> all;
    for (unsigned a = 0; a < watched_.size(); ++a) {
        if (!watched_[a]) continue;
        for (const auto& [limit, id, clock] : watched_[a]->values) {
            const AlarmLevel level = clock.level(limit, now);
            if (level == AlarmLevel::none) continue;
            all.push_back({static_cast<std::uint8_t>(a), limit, level, divided(clock.value(), limit), clock.since(level),
                           *clock.heard_at()});
        }
    }
    std::stable_partition(all.begin(), all.end(), [](const ActiveAlarm& alarm) { return alarm.level == AlarmLevel::red; });
    return all;
}

bool AlarmWatch::any_beyond() const noexcept {
    return std::any_of(watched_.begin(), watched_.end(), [](const auto& one) {
        return one && std::any_of(one->values.begin(), one->values.end(), [](const auto& v) { return v.clock.is_beyond(); });
    });
}

}    // namespace anogate
