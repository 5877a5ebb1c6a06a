// Limits lines of the log that others in the network can cause. No I/O, no clock.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <string>

namespace anogate {

class LineLimit {
public:
    static constexpr unsigned per_minute = 20;

    /// The line to be logged; empty: none. The last one of a minute says so.
    std::string limited(std::string line, ano::TimePoint now) {
        if (now - begun_at_ >= std::chrono::minutes{1}) {
            begun_at_ = now;
            count_ = 0;
        }
        if (count_ == per_minute) return {};
        if (++count_ == per_minute) line += "; further such lines within this minute are not shown";
        return line;
    }

private:
    ano::TimePoint begun_at_{};
    unsigned count_ = 0;    // lines since then
};

}    // namespace anogate
