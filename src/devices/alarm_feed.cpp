#include <devices/alarm_feed.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

template <typename Items>
bool are_same(const std::vector<Items>& a, const std::vector<Items>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const Items& one, const Items& other) { return one.is_same(other); });
}

}    // namespace

void AlarmFeed::set(std::uint8_t address, const AlarmLimits::List& limits, ano::TimePoint now) {
    watch_.set(address, limits, now);
    look_soon(now);
}

void AlarmFeed::forget(std::uint8_t address, ano::TimePoint now) {
    watch_.forget(address);
    look_soon(now);
}

void AlarmFeed::receive(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now, bool raises_only) {
    if (watch_.receive(source, reading, now, raises_only)) look_soon(now);
}

void AlarmFeed::look_soon(ano::TimePoint now) { look_at(now + between_looks); }

void AlarmFeed::look_at(ano::TimePoint at) {
    if (!clients_.empty()) due_ = std::min(due_.value_or(at), at);
}

void AlarmFeed::look(std::vector<WatchedDevice> devices, ano::TimePoint now) {
    const bool stood_still = due_ && now - *due_ > too_late;
    due_.reset();
    if (stood_still) return look_soon(now);
    auto active = watch_.active(now);
    const bool is_same = are_same(active, sent_alarms_) && are_same(devices, sent_devices_);
    bool must_resend = !active.empty();
    sent_as_present_.reset();
    for (const WatchedDevice& device : devices) {
        sent_as_present_[device.address] = !device.is_lost;
        if (!device.is_lost) look_at(std::max(device.lost_at, now + between_looks));
        else if (!device.was_locked() || now - device.heard_at < locked_reported_for) must_resend = true;
    }
    if (watch_.any_beyond()) look_soon(now);
    if (!is_same || (must_resend && now - sent_at_ >= resend_interval)) {
        sent_alarms_ = std::move(active);
        sent_devices_ = std::move(devices);
        sent_at_ = now;
        ++version_;
        clients_.wake();
    }
    if (must_resend) look_at(sent_at_ + resend_interval);
}

}    // namespace anogate
