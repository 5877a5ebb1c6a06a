// The one clock type of the library. Nothing here reads a clock: every function that needs the time is given it.
#pragma once
#include <chrono>

namespace ano {

using Clock = std::chrono::steady_clock;
using TimePoint = Clock::time_point;
using Duration = Clock::duration;

}    // namespace ano
