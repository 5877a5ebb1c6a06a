// Logs standstills of the loop, in few lines.
#pragma once
#include <gateway/arrival.hpp>

#include <cstdint>

namespace anogate {

/// Five lines at once, then one in ten seconds: on a machine that is too slow there are always standstills.
class StandstillLog {
public:
    void stood(const LoopWatch::Turn& turn, ano::TimePoint now);
    /// At the end of the program: reports the rest.
    void finish() const;

private:
    ano::TimePoint next_{};    // when the next line may be logged
    std::uint64_t unsaid_ = 0;
};

}    // namespace anogate
