// How long an answer of one device may take, from its own round trips (RFC 6298).
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <cstddef>
#include <optional>

namespace ano::host {

class RoundTrip {
public:
    static constexpr Duration first = std::chrono::milliseconds{200};    // before the first measurement
    static constexpr Duration floor = std::chrono::milliseconds{30};
    static constexpr Duration ceiling = std::chrono::seconds{2};
    /// The minimum that is added to the mean: a USB adapter delivers received bytes only every 16 ms.
    static constexpr Duration granularity = std::chrono::milliseconds{20};
    /// After this many repeated exchanges in a row, and an answer that arrived twice, one exchange is measured from its first
    /// send: if every answer takes longer than the time-out, nothing would ever be measured otherwise. If frames are lost,
    /// answers arrive once.
    static constexpr int repeated_enough = 3;

    /// An exchange was answered `since_first` after its first send. A repeated one is not measured, since it is not known which
    /// send was answered (Karn's rule).
    void answered(Duration since_first, bool repeated) noexcept;
    /// An answer arrived again: both sends of a request were received.
    void doubled() noexcept { doubled_ = true; }

    /// SRTT + 4 RTTVAR, within floor and ceiling.
    Duration time_out() const noexcept;
    /// The time-out of a send after `losses` sends of the same exchange were lost. It is doubled for each, within the ceiling, as
    /// long as nothing was measured or round trips grow with the load. Otherwise a loss does not show how much time an answer
    /// needs: if `answers`, that is, the device has answered any request since the last send, it is not doubled before
    /// losses_in_a_row; in all other cases it is doubled at most max_doublings times. `by_itself`: no other request is in flight,
    /// so the answer does not take several times the shortest time.
    Duration time_out_after(unsigned losses, bool answers, bool by_itself = false) const noexcept;
    static constexpr unsigned max_doublings = 2;
    static constexpr unsigned losses_in_a_row = 5;
    /// Answers take clearly longer than with the fewest requests in flight.
    bool grows() const noexcept { return smoothed_ && *smoothed_ > 2 * least_ + granularity; }
    /// A request that was sent once was answered; `others` were in flight when it was sent.
    void answered_behind(std::size_t others, Duration time) noexcept;
    /// Whether answers behind at least half as many others were measured: they may take much longer than one by itself.
    bool knows_others(std::size_t others) const noexcept { return behind_others_ && 2 * others_ >= static_cast<double>(others); }
    /// The number of requests that yield that may be in flight so that one waits for the others at most max_wait, computed from
    /// the time by which each of them has lengthened round trips; at least two. This bounds the delay of a command at a device
    /// that needs long for each frame.
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
