// Detects that a device has restarted, from the frames that it sends or does not send.
#pragma once
#include <ano/fault.hpp>
#include <host/device.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace ano::host {

/// Signs of a restart: a gap in its samples, or before the first one; device info that was not asked for; device info that has
/// changed, or a long absence.
class RestartWatch {
public:
    /// A longer gap is a sign. For a device that sends fewer than six samples a second, a gap longer than three usual intervals
    /// is.
    static constexpr Duration max_gap = std::chrono::milliseconds{500};
    static constexpr unsigned usual_gaps = 3;

    RestartWatch(const Device& device, TimePoint now) noexcept
        : presence_{device.presence()}, announcements_{device.announcements()}, begun_{now}, last_{now} {}

    /// To be called with each sample.
    void sampled(TimePoint now);
    /// The first sign, as a clause; empty: none.
    Fault sign(const Device& device) const;
    /// If the sign is a gap that began within max_gap of the beginning: its length, as text; otherwise empty.
    std::string silence_at_begin() const;
    /// The time of the last sample, or of the beginning.
    TimePoint sampled_at() const noexcept { return last_; }

private:
    std::uint32_t presence_, announcements_;
    TimePoint begun_, last_;
    bool is_sampled_ = false;
    TimePoint longest_since_{};
    Duration longest_{};    // also from the beginning to the first sample; judged again when the pace is known better
    std::optional<Duration> usual_;
    std::optional<Duration> gap_;
};

}    // namespace ano::host
