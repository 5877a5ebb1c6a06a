#include <devices/alarm_feed.hpp>

#include <algorithm>
#include <utility>

namespace anogate {

void AlarmFeed::set(std::uint8_t address, const AlarmLimits::List& limits, ano::TimePoint now) {
    watch_.set(address, limits, now);
    look_soon(now);
}

void AlarmFeed::forget(std::uint8_t address, ano::TimePoint now) {
    watch_.forget(address);
    look_soon(now);
}

void AlarmFeed::hear(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now) {
    if (watch_.hear(source, reading, now)) look_soon(now);
}

void AlarmFeed::look_soon(ano::TimePoint now) {
    if (!clients_.empty() && !due_) due_ = now + between_looks;
}

void AlarmFeed::look(ano::TimePoint now) {
    due_.reset();
    auto active = watch_.active(now);
    const bool is_same = std::equal(active.begin(), active.end(), told_.begin(), told_.end(),
                                    [](const ActiveAlarm& a, const ActiveAlarm& b) { return a.is_same(b); });
    if (watch_.any_beyond()) look_soon(now);
    if (is_same && (active.empty() || now - told_at_ < told_every)) return;
    told_ = std::move(active);
    told_at_ = now;
    ++version_;
    clients_.wake();
}

}    // namespace anogate
