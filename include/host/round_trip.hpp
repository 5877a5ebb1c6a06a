// How long an answer of one device may take, by its own round trips (RFC 6298).
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <cstddef>
#include <optional>

namespace ano::host {

class RoundTrip {
public:
    static constexpr Duration first = std::chrono::milliseconds{200};    // before anything was measured
    static constexpr Duration floor = std::chrono::milliseconds{30};
    static constexpr Duration ceiling = std::chrono::seconds{2};
    /// The minimum that is added to the mean: a USB adapter delivers what it received only every 16 ms.
    static constexpr Duration granularity = std::chrono::milliseconds{20};
    /// After this many repeated exchanges in a row, and an answer that came twice, one is measured from its first send: where every answer
    /// takes longer than the time-out, nothing would ever be measured otherwise. Where frames are lost, answers come once.
    static constexpr int repeated_enough = 3;

    /// An exchange was answered `since_first` after its first send. One that was repeated is not measured, since it is not known which
    /// send was answered (Karn's rule).
    void answered(Duration since_first, bool repeated) noexcept;
    /// An answer came again: both sends of a request had arrived.
    void doubled() noexcept { doubled_ = true; }

    /// SRTT + 4 RTTVAR, within floor and ceiling.
    Duration time_out() const noexcept;
    /// The time-out of a send after `losses` of the same exchange: doubled for each, within the ceiling, as long as nothing was measured or
    /// round trips grow with the load. Otherwise a loss says nothing about the time that an answer needs: not doubled if `answers`, the
    /// device has answered something since the last send, and at most max_doublings times if not, or after losses_in_a_row.
    /// `by_itself`: no other request is on its way, so that the answer does not take several times as long as the least one did.
    Duration time_out_after(unsigned losses, bool answers, bool by_itself = false) const noexcept;
    static constexpr unsigned max_doublings = 2;
    static constexpr unsigned losses_in_a_row = 5;
    /// Answers take clearly longer than when the least was on its way.
    bool grows() const noexcept { return smoothed_ && *smoothed_ > 2 * least_ + granularity; }
    /// A request that was sent once was answered, with `others` on their way when it was sent.
    void answered_behind(std::size_t others, Duration time) noexcept;
    /// So many requests that yield may be on their way that one waits for the others no longer than max_wait, by how much each of those has added to
    /// round trips; at least two. So a command, too, finds a device free soon that needs long for each frame.
    std::size_t bearable() const noexcept;
    static constexpr Duration max_wait = std::chrono::milliseconds{40};
    /// SRTT; std::nullopt before the first measurement.
    std::optional<Duration> smoothed() const noexcept { return smoothed_; }

private:
    std::optional<Duration> smoothed_;
    Duration variation_{};
    Duration least_ = Duration::max();                     // measured
    std::optional<Duration> by_itself_, behind_others_;    // smoothed
    double others_ = 0;                                    // smoothed, of behind_others_
    int repeated_in_a_row_ = 0;
    bool doubled_ = false;    // since an exchange that was not repeated
};

}    // namespace ano::host
