// Where the program's rooms come from (ano/room.hpp).
#pragma once

namespace anogate {

/// From now on each room is mapped by itself, and unmapped when it goes.
void take_rooms_from_the_system() noexcept;

}  // namespace anogate
