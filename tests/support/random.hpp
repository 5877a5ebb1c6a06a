// Random choices that a seed repeats.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <random>

namespace support {

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
