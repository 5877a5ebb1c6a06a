// Where the control socket is when nobody said, and where there can be one.
#pragma once
#include <optional>
#include <string>

namespace anogate::http {

/// Who runs the program, as far as it matters here.
struct Runner {
    bool system = false;        // root, or somebody who may write to /run/anogate
    std::string runtime_dir;    // $XDG_RUNTIME_DIR; empty: not set
};
Runner this_runner();

/// The path of the control socket; nothing when `configured` is "none". Empty: nobody said.
std::optional<std::string> control_socket(const std::string& configured, const Runner& runner);

/// That of the gateway of the system.
std::string system_socket();

/// Where a client looks, when `asked` is empty: who is no system user finds the gateway of the system where he runs none of his own.
std::string socket_to_ask(const std::string& asked, const Runner& runner);

/// Why no socket can be made at `path`, as far as it shows without trying; empty: one can, or it is in use.
std::string fault_of_socket(const std::string& path, const Runner& runner);

}    // namespace anogate::http
