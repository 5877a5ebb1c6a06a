// Pseudo-random numbers: a seed gives the same numbers on every computer and with every standard library.
#pragma once
#include <cstdint>

namespace ano::world {

/// SplitMix64. Different seeds give independent sequences.
class Noise {
public:
    explicit Noise(std::uint64_t seed) noexcept : state_{seed} {}

    std::uint64_t bits() noexcept {
        std::uint64_t z = state_ += 0x9E37'79B9'7F4A'7C15;
        z = (z ^ (z >> 30)) * 0xBF58'476D'1CE4'E5B9;
        z = (z ^ (z >> 27)) * 0x94D0'49BB'1331'11EB;
        return z ^ (z >> 31);
    }
    /// From 0 to below 1.
    double share() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    /// From -max to max.
    double within(double max) noexcept { return (2 * share() - 1) * max; }
    /// Approximately normal, variance 1: the sum of four numbers of 16 bits.
    double normal() noexcept {
        constexpr double half = 2 * 65535.0, deviation = 37837.2;
        const std::uint64_t b = bits();
        const std::uint64_t sum = (b & 0xFFFF) + (b >> 16 & 0xFFFF) + (b >> 32 & 0xFFFF) + (b >> 48);
        return (static_cast<double>(sum) - half) / deviation;
    }

private:
    std::uint64_t state_;
};

}    // namespace ano::world
