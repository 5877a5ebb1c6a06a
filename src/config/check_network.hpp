// Checks what is reachable from the network with a configuration that has no other errors.
#pragma once
#include <config/config.hpp>
#include <gateway/ip.hpp>

namespace anogate {

/// Adds an error if peers in the network can reach programs on loopback through tunnel frames, unless `relay` allows it
/// explicitly.
void check_relay(Draft& draft);

/// The same for the addresses of our interfaces, `own`. These are known only on the machine and may change, so only --check calls
/// this.
void check_relay(Draft& draft, const std::vector<Network>& own);

/// Adds one note to the warnings if any links are open to all networks of this computer: what that means, and what to do.
void note_open_ports(Draft& draft);

}    // namespace anogate
