// How many file descriptors this program may still open.
#pragma once
#include <cstddef>

namespace anogate {

/// At least so many; those of numbers below others that are open are not counted.
std::size_t descriptors_left() noexcept;

/// So many are kept for links, whatever the clients of the control interface do; fewer where the program may have few at all.
std::size_t descriptors_of_links() noexcept;

}    // namespace anogate
