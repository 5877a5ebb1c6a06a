// Counts allocations in a program that is linked to allocations.cpp.
#pragma once
#include <cstdint>

namespace support {

/// Number of allocations since the program started.
extern std::uint64_t allocations;

}    // namespace support
