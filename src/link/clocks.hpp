// The clocks of the system, read together.
#pragma once
#include <gateway/arrival.hpp>

#include <ctime>

namespace anogate {

inline ano::Duration duration_of(const timespec& time) noexcept {
    return std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec};
}

inline ano::Duration time_by(clockid_t clock) noexcept {
    timespec time{};
    ::clock_gettime(clock, &time);
    return duration_of(time);
}

inline ClockReading read_clocks() noexcept { return {ano::Clock::now(), time_by(CLOCK_BOOTTIME), time_by(CLOCK_REALTIME)}; }

}    // namespace anogate
