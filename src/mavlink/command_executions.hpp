// The commands of ground stations to one vehicle: each is carried out once, however often the station repeats it. No I/O, no clock.
#pragma once
#include <ano/time.hpp>
#include <mavlink/station_command.hpp>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

namespace anogate::mavlink {

class CommandExecutions {
public:
    /// A command that the station repeats by its count is a repeat for this time, and an identical one without a count for the other.
    static constexpr ano::Duration counted_repeats = std::chrono::seconds{60}, plain_repeats = std::chrono::seconds{5};
    static constexpr std::size_t max_kept = 64;

    using Done = std::function<void(Result)>;
    /// Carries a command out, now or later; calls `done` once. Not called for repeats.
    using CarryOut = std::function<void(const StationCommand& command, Done done)>;
    using Acknowledge = std::function<void(const StationCommand& command, Result result)>;

    CommandExecutions(CarryOut carry_out, Acknowledge acknowledge)
        : carry_out_{std::move(carry_out)}, acknowledge_{std::move(acknowledge)} {}
    CommandExecutions(const CommandExecutions&) = delete;
    CommandExecutions& operator=(const CommandExecutions&) = delete;

    void receive(const StationCommand& command, ano::TimePoint now);
    std::uint64_t repeats() const noexcept { return repeats_; }

private:
    struct Execution {
        std::uint64_t number = 0;
        StationCommand command{};
        std::optional<Result> result{};    // std::nullopt: it is being carried out
        ano::TimePoint heard_at{};
    };
    Execution* repeated(const StationCommand& command, ano::TimePoint now) noexcept;
    void end(std::uint64_t number, Result result);

    CarryOut carry_out_;
    Acknowledge acknowledge_;
    std::deque<Execution> kept_;    // the newest last
    std::uint64_t count_ = 0, repeats_ = 0;
};

}    // namespace anogate::mavlink
