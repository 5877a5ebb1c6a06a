// The clock type of the library. The library reads no clock: each function that needs the time gets it as an argument.
#pragma once
#include <chrono>

namespace ano {

using Clock = std::chrono::steady_clock;
using TimePoint = Clock::time_point;
using Duration = Clock::duration;

}    // namespace ano
