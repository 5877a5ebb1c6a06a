// Counts what is allocated, in a program that allocations.cpp is linked to.
#pragma once
#include <cstdint>

namespace support {

/// Since the program began.
extern std::uint64_t allocations;

}    // namespace support
