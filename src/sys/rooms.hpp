// The memory resource of the program's rooms (ano/room.hpp).
#pragma once
#include <cstddef>

namespace anogate {

/// After this call, each room is a separate memory mapping, which is unmapped when the room is freed.
void map_rooms_separately() noexcept;

/// Whether the system could provide `size` more bytes now.
bool memory_is_left(std::size_t size) noexcept;

}    // namespace anogate
