// Waits for a condition, never for a fixed time.
#pragma once
#include <chrono>
#include <functional>
#include <thread>

namespace support {

/// The limit that ends a hanging test. Tests that work never reach it, even on a busy or emulated machine.
inline constexpr std::chrono::seconds patience{60};

/// Calls `holds` until it returns true or `limit` is over; returns its last result. `pause` runs between two calls.
template <class Pause>
bool wait_until(const std::function<bool()>& holds, std::chrono::steady_clock::duration limit, Pause pause) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!holds()) {
        if (std::chrono::steady_clock::now() >= end) return holds();
        pause();
    }
    return true;
}

inline bool wait_until(const std::function<bool()>& holds, std::chrono::steady_clock::duration limit = patience) {
    return wait_until(holds, limit, [] { std::this_thread::sleep_for(std::chrono::milliseconds{2}); });
}

}    // namespace support
