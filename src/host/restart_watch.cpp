#include <host/restart_watch.hpp>

#include <algorithm>
#include <utility>

namespace ano::host {
namespace {

// Text for people: "1.2 s".
std::string length_of_gap(Duration time) {
    const auto tenths = std::chrono::duration_cast<std::chrono::milliseconds>(time).count() / 100;
    return std::to_string(tenths / 10) + '.' + std::to_string(tenths % 10) + " s";
}

}    // namespace

void RestartWatch::sampled(TimePoint now) {
    const Duration interval = now - std::exchange(last_, now);
    if (interval > longest_) longest_since_ = now - interval;
    longest_ = std::max(longest_, interval);
    if (usual_ && longest_ > std::max(max_gap, usual_gaps * *usual_)) gap_ = gap_.value_or(longest_);
    if (std::exchange(is_sampled_, true)) usual_ = usual_ ? (7 * *usual_ + interval) / 8 : interval;
}

std::string RestartWatch::silence_at_begin() const {
    return gap_ && longest_since_ - begun_ <= max_gap ? length_of_gap(*gap_) : std::string{};
}

Fault RestartWatch::sign(const Device& device) const {
    if (gap_) return {"no_samples_for", length_of_gap(*gap_)};
    if (device.announcements() != announcements_) return {"info_unasked"};
    return device.presence() != presence_ ? Fault{"info_changed"} : Fault{};
}

}    // namespace ano::host
