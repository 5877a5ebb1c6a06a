// When to connect to the broker again, and when to take renewed certificates. No I/O, no clock.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string_view>

namespace anogate {

/// Pauses from 1 s to 60 s with full jitter, so that a fleet does not come back in one moment.
class Reconnection {
public:
    static constexpr std::chrono::milliseconds first{1000}, longest{60'000};
    static constexpr std::chrono::milliseconds stable{10'000};    // a connection that lasts so long begins anew

    /// `random`: from 0 to 1.
    std::chrono::milliseconds pause(double random) noexcept {
        const auto pause = std::chrono::milliseconds{static_cast<std::int64_t>(random * static_cast<double>(limit_.count()))};
        limit_ = std::min(2 * limit_, longest);
        return pause;
    }
    void on_connected_for(ano::Duration time) noexcept {
        if (time >= stable) limit_ = first;
    }

private:
    std::chrono::milliseconds limit_ = first;
};

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
