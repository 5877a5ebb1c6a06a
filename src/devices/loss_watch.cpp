#include <ano/typed.hpp>
#include <devices/loss_watch.hpp>

#include <algorithm>

namespace anogate {

void LossWatch::receive(std::uint8_t address, std::uint8_t id, ano::TimePoint now) noexcept {
    Life& life = lives_[address];
    life.heard_at = now;
    life.elsewhere.clear();
    if (!is_telemetry(id)) return;
    if (now - life.at > rarest_telemetry) life.intervals = 0;
    else if (!life.sends_telemetry()) ++life.intervals;
    life.at = now;
}

void LossWatch::record_mode(std::uint8_t address, std::uint8_t flag, ano::TimePoint now) noexcept {
    receive(address, ano::id_of<"mode">, now);
    Life& life = lives_[address];
    const ano::Duration interval = now - life.mode_at;
    if (life.flag && interval <= rarest_telemetry) life.mode_intervals[life.mode_count++ % periods] = interval;
    life.mode_at = now;
    life.flag = flag;
}

ano::Duration LossWatch::Life::allowed_silence() const noexcept {
    if (!flag) return rarest_telemetry;
    const ano::Duration period = *std::max_element(mode_intervals.begin(), mode_intervals.end());
    return mode_count < periods || heard_at - mode_at > patience + period ? lost_after : patience + period;
}

std::optional<WatchedDevice> LossWatch::device(std::uint8_t address, ano::TimePoint now) const {
    const Life& life = lives_[address];
    if (!life.flag && !life.sends_telemetry()) return std::nullopt;
    const ano::TimePoint lost_at = life.heard_at + life.allowed_silence();
    return WatchedDevice{address, life.heard_at, life.flag, lost_at, now >= lost_at, life.elsewhere};
}

}    // namespace anogate
