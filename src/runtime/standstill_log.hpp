// Logs standstills of the loop, with a limited number of lines.
#pragma once
#include <gateway/arrival.hpp>

#include <cstdint>

namespace anogate {

/// At most five lines at once, then one per ten seconds, because a machine that is too slow has standstills all the time.
class StandstillLog {
public:
    void stood(const StallDetector::Turn& turn, ano::TimePoint now);
    /// To be called at the end of the program: logs the rest.
    void finish() const;

private:
    ano::TimePoint next_{};    // earliest time of the next line
    std::uint64_t unreported_ = 0;
};

}    // namespace anogate
