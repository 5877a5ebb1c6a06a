// Durations as text for the user.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <string>

namespace anogate::http {

/// "30 s", "100 ms".
inline std::string seconds_text(ano::Duration time) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
    return ms % 1000 == 0 ? std::to_string(ms / 1000) + " s" : std::to_string(ms) + " ms";
}

}    // namespace anogate::http
