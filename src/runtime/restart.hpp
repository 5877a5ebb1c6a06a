// Restart without loss: passes open descriptors, and the state of their peers, from one run of the service to the next.
#pragma once
#include <runtime/restart_state.hpp>

namespace anogate {

/// The state that the previous run stored; empty without one, or without systemd. Descriptors that can't be used are closed.
RestartState receive_restart_state();

/// Stores the state of the gateway for the next run; it stopped reading at `unread_since`.
void send_restart_state(const Gateway& gateway, const ClockReading& unread_since);

}    // namespace anogate
