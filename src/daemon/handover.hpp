// Restart without loss: wires that stay open, and what is known of who is behind them, go from one run of the service to the next.
#pragma once
#include <daemon/stored_state.hpp>

namespace anogate {

/// What the run before left; empty without one, or without systemd. Descriptors that are of no use are closed.
StoredState take_handover();

/// Leaves what the gateway has. It reads no more.
void hand_over(const Gateway& gateway);

}    // namespace anogate
