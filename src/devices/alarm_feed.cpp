#include <devices/alarm_feed.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

template <typename Told>
bool are_same(const std::vector<Told>& a, const std::vector<Told>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const Told& one, const Told& other) { return one.is_same(other); });
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

void AlarmFeed::hear(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now, bool raises_only) {
    if (watch_.hear(source, reading, now, raises_only)) look_soon(now);
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
    const bool is_same = are_same(active, told_) && are_same(devices, told_devices_);
    bool tells_again = !active.empty();
    told_as_heard_.reset();
    for (const WatchedDevice& device : devices) {
        told_as_heard_[device.address] = !device.is_lost;
        if (!device.is_lost) look_at(std::max(device.lost_at, now + between_looks));
        else if (!device.was_locked() || now - device.heard_at < tells_locked) tells_again = true;
    }
    if (watch_.any_beyond()) look_soon(now);
    if (!is_same || (tells_again && now - told_at_ >= told_every)) {
        told_ = std::move(active);
        told_devices_ = std::move(devices);
        told_at_ = now;
        ++version_;
        clients_.wake();
    }
    if (tells_again) look_at(told_at_ + told_every);
}

}    // namespace anogate
