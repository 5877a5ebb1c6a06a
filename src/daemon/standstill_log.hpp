// That the loop stood still, in few lines.
#pragma once
#include <gateway/arrival.hpp>

#include <cstdint>

namespace anogate {

/// Five lines at once, then one in ten seconds: on a machine that is too slow for what it has to do, it stands still all the time.
class StandstillLog {
public:
    void stood(const LoopWatch::Turn& turn, ano::TimePoint now);
    /// Nothing more will be told.
    void finish() const;

private:
    ano::TimePoint next_{};    // when there is room for another line
    std::uint64_t unsaid_ = 0;
};

}    // namespace anogate
