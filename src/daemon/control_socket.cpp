#include <daemon/control_socket.hpp>

#include <unistd.h>

#include <cstdlib>

namespace anogate {

Runner this_runner() {
    const char* runtime_dir = std::getenv("XDG_RUNTIME_DIR");
    return {geteuid() == 0 || access("/run/anogate", W_OK) == 0, runtime_dir != nullptr ? runtime_dir : ""};
}

std::string control_socket(const ControlSettings& settings, const Runner& runner) {
    if (!settings.socket.empty()) return settings.socket;
    // Without either, the error of the first is the one that tells people what to do.
    if (runner.system || runner.runtime_dir.empty()) return "/run/anogate/control.sock";
    return runner.runtime_dir + "/anogate.sock";
}

}  // namespace anogate
