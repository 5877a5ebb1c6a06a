// Reports standstills of the loop, in few lines.
#pragma once
#include <gateway/arrival.hpp>

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

namespace anogate {

/// Five lines at once, then one in ten seconds: on a machine that is too slow there are always standstills.
class StandstillLog {
public:
    void stood(const LoopWatch::Turn& turn, ano::TimePoint now) {
        if (!turn.is_told) return;
        if (now < next_) return void(++unsaid_);
        next_ = std::max(next_, now - at_once * spacing) + spacing;
        const double seconds = std::chrono::duration<double>(turn.stood).count();
        const char* why = turn.suspended > ano::Duration::zero() ? "the machine slept" : "stopped, or the machine was too busy";
        const std::string more = unsaid_ == 0 ? "" : "; " + std::to_string(std::exchange(unsaid_, 0)) + " times more before";
        spdlog::warn("stood still for at least {:.1f} s ({}): what came meanwhile counts as that old{}", seconds, why, more);
    }
    /// At the end of the program: reports the rest.
    void finish() const {
        if (unsaid_ > 0) spdlog::warn("stood still {} times more", unsaid_);
    }

private:
    static constexpr ano::Duration spacing = std::chrono::seconds{10};
    static constexpr int at_once = 5;

    ano::TimePoint next_{};    // when there is room for another line
    std::uint64_t unsaid_ = 0;
};

}    // namespace anogate
