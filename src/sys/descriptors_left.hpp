// The number of file descriptors that this program may still open.
#pragma once
#include <cstddef>

namespace anogate {

/// The number of descriptors that connections, peers and downloads may still use. Eight more are reserved for short work of the
/// gateway itself, such as reading its configuration.
std::size_t descriptors_left() noexcept;

/// Whether a client of this computer may use one of the reserved descriptors, for a short request: enough for such work stay free.
bool may_use_reserved_descriptor() noexcept;

/// False if the program, the system or the memory allows no further descriptor: a file that can't be read now may be without fault.
bool can_open_descriptors() noexcept;

/// The number of descriptors reserved for links; fewer if the limit of the program is low.
std::size_t descriptors_of_links() noexcept;

/// The number of descriptors that clients of the control interface leave free, for links and for the peers of listening links: at
/// most half of all.
std::size_t descriptors_of_links_and_peers() noexcept;

}    // namespace anogate
