// Estimates when the messages of a periodic stream were sent, from the times at which they arrived: no message arrives early, so
// the line below all arrivals is the sender's clock, later by the shortest delay. No I/O, no clock.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace anogate {

class ArrivalEnvelope {
public:
    /// Arrivals. Before so many, and while the stream is not periodic, a stamp is the arrival.
    static constexpr std::size_t window = 100;
    static constexpr std::size_t needed = 10;    // for a line, once the period is known

    /// The stamp of a message that arrived at `arrival_ns`, of a clock that does not go back: never in the future, never before the
    /// stamp of the previous message, and at most one period before `arrival_ns`.
    std::uint64_t stamp(std::uint64_t arrival_ns) noexcept;

private:
    using Times = std::array<double, window>;    // of the arrivals, in ns relative to the last one

    void add(std::uint64_t arrival_ns) noexcept;
    double slope(const Times& times) const noexcept;
    /// How late the last arrival is, by the line of this period below the arrivals from the i-th on.
    double delay_from(std::size_t i, const Times& times) const noexcept;
    double mean_delay(double delay_of_last, const Times& times) const noexcept;
    void shorten(Times& times) noexcept;
    std::uint64_t estimate() noexcept;

    std::array<std::uint64_t, window> arrivals_{};
    std::size_t count_ = 0;
    std::size_t since_slope_ = 0;     // arrivals
    double period_ = 0;               // ns
    bool is_period_known_ = false;    // from a whole window
    std::uint64_t stamp_ns_ = 0;
};

}    // namespace anogate
