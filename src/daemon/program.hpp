// Runs the daemon, from its command line to its exit status.
#pragma once

namespace anogate {

/// Returns 0: done, or stopped by SIGTERM or SIGINT. 1: a required link is not up. 78: the configuration has faults.
int run_program(int argc, char** argv);

}    // namespace anogate
