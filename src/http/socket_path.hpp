// The default path of the control socket, and whether a socket can be made at a path.
#pragma once
#include <optional>
#include <string>

namespace anogate::http {

/// The user that runs the program.
struct Runner {
    bool system = false;        // root, or a user that may write to /run/anogate
    std::string runtime_dir;    // $XDG_RUNTIME_DIR; empty: not set
};
Runner this_runner();

/// The path of the control socket; std::nullopt if `configured` is "none". An empty `configured` means the default.
std::optional<std::string> control_socket(const std::string& configured, const Runner& runner);

/// The path of the system's gateway.
std::string system_socket();

/// The path that a client connects to: `asked` if it is not empty. For a normal user whose own gateway does not run: the path of
/// the system's gateway.
std::string socket_to_ask(const std::string& asked, const Runner& runner);

/// The reason why no socket can be made at `path`, found without making one; empty: it can be made, or is in use.
std::string fault_of_socket(const std::string& path, const Runner& runner);

}    // namespace anogate::http
