// Random choices that are reproducible by their seed.
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <random>

namespace support {

/// The number of trials of a test that usually makes `usual`. On emulated machines, ANOGATE_TRIALS is set to a percentage of
/// them; at least one is made.
inline std::uint64_t trials(std::uint64_t usual) {
    const char* const text = std::getenv("ANOGATE_TRIALS");
    const std::uint64_t percent = text ? std::strtoull(text, nullptr, 10) : 100;
    return percent >= 100 ? usual : std::max<std::uint64_t>(usual * percent / 100, 1);
}

class Random {
public:
    explicit Random(std::uint64_t seed) : engine_{seed} {}

    /// 0 to n - 1.
    template <class Number>
    Number below(Number n) {
        return static_cast<Number>(engine_() % static_cast<std::uint64_t>(n));
    }
    std::uint8_t byte() { return static_cast<std::uint8_t>(engine_()); }
    bool one_in(unsigned n) { return below(n) == 0; }
    template <class T>
    T of(std::initializer_list<T> choices) {
        return choices.begin()[below(choices.size())];
    }

private:
    std::mt19937_64 engine_;
};

}    // namespace support
