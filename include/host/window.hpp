// How many requests may be in flight to a device.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>

namespace ano::host {

/// Opens by one for each answer, to 8: field devices queue 20 frames and drop the rest silently. If more than half of the last 16
/// sends were lost, it halves if round trips grow with the load: the line or the device is overloaded. Otherwise the device may
/// lose questions while it answers another: from then on requests are sent one at a time, unless those are lost as well. This
/// mode ends when two answers arrived late that counted as lost, or when two at a time are not lost either, which is checked now
/// and then.
///
/// A send counts as lost only if the time for its answer was measured.
class Window {
public:
    static constexpr std::size_t max_size = 8;
    static constexpr int remembered = 16;    // sends
    /// Of the last 16 requests that were sent one at a time this many may be lost, of the first 8 none. If more are lost, the
    /// line loses them.
    static constexpr int may_be_lost_alone = 2;
    static constexpr unsigned first_alone = 8;
    static constexpr unsigned between_trials = 256;    // sends
    /// After this many sends one at a time, eight times as many after each check, the next `checked` are sent two at a time. If
    /// more than may_be_lost_in_check of these are lost, the mode stays.
    static constexpr unsigned first_check = 32, checked = 16, check_factor = 8;
    static constexpr int may_be_lost_in_check = 1;
    static constexpr int late_enough = 2;    // answers

    std::size_t size() const noexcept { return one_at_a_time_ ? 1 : checks_ ? 2 : size_; }
    /// No request is sent while another one is in flight.
    bool is_one_at_a_time() const noexcept { return one_at_a_time_; }
    /// `alone`: the request was sent while this was one at a time, and no other one was in flight.
    void answered(bool alone) noexcept {
        if (one_at_a_time_ && !alone) return;
        note(0);
        if (one_at_a_time_) {
            if (sends_ - trial_began_ >= check_after_) begin_check();
        } else if (checks_) {
            if (sends_ - trial_began_ >= checked) pass_check();
        } else if (size_ < max_size) ++size_;
    }
    /// The answer to a send that counted as lost arrived: its time-out was too short.
    void on_late_answer() noexcept {
        if (++late_ >= late_enough && (one_at_a_time_ || checks_)) reset_trial();
        losses_ = static_cast<std::uint16_t>(losses_ & (losses_ - 1));    // without the newest one
    }
    void lost(bool alone, bool round_trips_grow) noexcept {
        if (one_at_a_time_ && !alone) return;
        note(1);
        const int losses = std::popcount(losses_);
        if (one_at_a_time_) {
            if (losses > (sends_ - trial_began_ <= first_alone ? 0 : may_be_lost_alone)) end_trial();
        } else if (checks_) {
            if (losses > may_be_lost_in_check) fail_check();
        } else if (2 * losses > remembered) {
            losses_ = 0;    // earlier losses don't apply to the smaller window
            if (round_trips_grow) size_ = size_ > 1 ? size_ / 2 : 1;
            else begin_trial();
        }
    }

private:
    void note(std::uint16_t loss) noexcept {
        losses_ = static_cast<std::uint16_t>(losses_ << 1 | loss);
        ++sends_;
    }
    void begin_trial() noexcept {
        one_at_a_time_ = size_ > 1 && sends_ >= next_trial_;
        trial_began_ = sends_;
        check_after_ = first_check;
        late_ = 0;
    }
    void end_trial() noexcept {
        one_at_a_time_ = false;
        losses_ = 0;
        next_trial_ = sends_ + between_trials;
    }
    void begin_check() noexcept {
        one_at_a_time_ = false;
        checks_ = true;
        losses_ = 0;
        trial_began_ = sends_;
        late_ = 0;
    }
    void fail_check() noexcept {
        checks_ = false;
        one_at_a_time_ = true;
        losses_ = 0;
        trial_began_ = sends_;
        check_after_ *= check_factor;
    }
    // Allows another trial at once: the mode was right until the check.
    void pass_check() noexcept {
        reset_trial();
        next_trial_ = sends_;
    }
    void reset_trial() noexcept {
        end_trial();
        checks_ = false;
        size_ = 2;
    }

    std::size_t size_ = 1;
    std::uint16_t losses_ = 0;    // a bit for each of the last sends
    bool one_at_a_time_ = false;
    bool checks_ = false;    // checks whether the mode is still needed
    int late_ = 0;           // late answers since the trial or the check began
    std::uint64_t check_after_ = first_check;
    std::uint64_t sends_ = 0;
    std::uint64_t trial_began_ = 0;
    std::uint64_t next_trial_ = 0;    // in sends: no trial before this number
};

}    // namespace ano::host
