// The memory resource of the program's rooms (ano/room.hpp).
#pragma once
#include <cstddef>

namespace anogate {

/// From now on each room is mapped by itself, and unmapped when it is freed.
void take_rooms_from_the_system() noexcept;

/// Whether the system would give `size` more bytes now.
bool memory_is_left(std::size_t size) noexcept;

}    // namespace anogate
