// Where the control socket is when nobody said.
#pragma once
#include <gateway/settings.hpp>

#include <string>

namespace anogate {

/// Who runs the program, as far as it matters here.
struct Runner {
    bool system = false;        // root, or somebody who may write to /run/anogate
    std::string runtime_dir;    // $XDG_RUNTIME_DIR; empty: not set
};
Runner this_runner();

/// The path of the control socket, or "none" when that was set.
std::string control_socket(const ControlSettings& settings, const Runner& runner);

}  // namespace anogate
