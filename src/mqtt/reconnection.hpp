// When to connect to the broker again, and when to take renewed certificates. No I/O, no clock.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string_view>

namespace anogate {

inline constexpr std::chrono::milliseconds shortest_pause_limit{1000}, longest_pause_limit{60'000};
/// The end of a shorter connection is not the beginning of an outage.
inline constexpr std::chrono::milliseconds stable_connection{10'000};

/// The pause before the next attempt: at most as long as the outage lasts, so that a broker that was restarted has its fleet back at once,
/// and one that was down for long gets it within a minute. With full jitter: `random` is from 0 to 1.
constexpr std::chrono::milliseconds reconnect_pause(ano::Duration outage, double random) noexcept {
    const auto limit = std::clamp(std::chrono::duration_cast<std::chrono::milliseconds>(outage), shortest_pause_limit,
                                  longest_pause_limit);
    return std::chrono::milliseconds{static_cast<std::int64_t>(random * static_cast<double>(limit.count()))};
}

/// The times of a certificate, in seconds since 1970.
struct CertificateLife {
    std::int64_t begin = 0, end = 0;
    bool operator==(const CertificateLife&) const = default;
};

/// When to look for a renewed certificate: between half and 9/10 of its life, spread over a fleet by the name of the gateway.
constexpr std::int64_t renewal_time(const CertificateLife& life, std::string_view name) noexcept {
    constexpr std::uint64_t offset = 14695981039346656037U, prime = 1099511628211U;    // FNV-1a
    constexpr std::uint64_t steps = 1024;
    std::uint64_t hash = offset;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * prime;
    hash ^= hash >> 32;
    const double part = 0.5 + 0.4 * static_cast<double>(hash % steps) / static_cast<double>(steps);
    return life.begin + static_cast<std::int64_t>(part * static_cast<double>(life.end - life.begin));
}

}    // namespace anogate
