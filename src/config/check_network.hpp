// Checks which ports are reachable, by peers in the network and by links of this gateway, and how many peers there may be.
#pragma once
#include <config/config.hpp>
#include <gateway/host_spec.hpp>
#include <gateway/ip.hpp>

namespace anogate {

/// Adds an error if peers in the network can reach programs on loopback through tunnel frames, unless `relay` allows it
/// explicitly.
void check_relay(Draft& draft);

/// The same for the addresses of our interfaces, `own`. These are known only on the machine and may change, so only --check calls
/// this.
void check_relay(Draft& draft, const std::vector<Network>& own);

/// Adds a note if the links may have more peers together than the gateway has channels.
void check_channels(Draft& draft);

/// Adds an error for each link whose peer is a port of this gateway: its frames would return, be refused, or arrive at a
/// port for another purpose.
void check_peers(Draft& draft);

/// The same for the names and addresses that only this machine knows and that may change, so only --check calls this. `names`: from
/// the hosts file; `own`: of our interfaces.
void check_peers(Draft& draft, const HostAddresses& names, const std::vector<Network>& own);

/// Adds one note to the warnings if any links are open to all networks of this computer: what that means, and what to do.
void note_open_ports(Draft& draft);

}    // namespace anogate
