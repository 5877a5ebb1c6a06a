// How much work code does, told without a clock: the branches it goes through, and what it hands to the C library.
#pragma once
#include <cstdint>

namespace support {

/// Steps since the program began.
extern std::uint64_t steps;

}    // namespace support
