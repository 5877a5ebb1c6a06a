// The number of file descriptors that this program may still open.
#pragma once
#include <cstddef>

namespace anogate {

/// A lower bound: free numbers below the highest open descriptors may not be counted.
std::size_t descriptors_left() noexcept;

/// The number of descriptors reserved for links; fewer if the limit of the program is low.
std::size_t descriptors_of_links() noexcept;

/// The number of descriptors that clients of the control interface leave free, for links and for the peers of listening links: at
/// most half of all.
std::size_t descriptors_of_links_and_peers() noexcept;

}    // namespace anogate
