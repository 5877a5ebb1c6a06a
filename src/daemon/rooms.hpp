// Where the program's rooms come from (ano/room.hpp).
#pragma once
#include <cstddef>

namespace anogate {

/// From now on each room is mapped by itself, and unmapped when it goes.
void take_rooms_from_the_system() noexcept;

/// The system would give `size` bytes more, just now.
bool memory_is_left(std::size_t size) noexcept;

}    // namespace anogate
