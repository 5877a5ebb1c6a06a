// anogate-mavlink: the loop, and the connections to the gateway and to ground stations.
#pragma once

namespace anogate {

/// Runs the program; returns its exit status.
int run_mavlink(int argc, char** argv);

}    // namespace anogate
