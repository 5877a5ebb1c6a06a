// Who in the network may reach what, by a configuration that says nothing wrong otherwise.
#pragma once
#include <config/config.hpp>
#include <gateway/ip.hpp>

namespace anogate {

/// Adds an error when peers in the network may reach programs that listen on loopback by tunnel frames, and `relay` does not
/// say that they shall.
void check_relay(Draft& draft);

/// The same of the addresses of our interfaces, `own`: they are known only on the machine and come and go, so only a check asks.
void check_relay(Draft& draft, const std::vector<Network>& own);

/// Adds one line when any number of links are open to all networks of this computer: what that means, and what to do. No fault.
void note_open_ports(Draft& draft);

}    // namespace anogate
