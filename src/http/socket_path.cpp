#include <http/socket_path.hpp>
#include <sys/errors.hpp>
#include <sys/files/own_folder.hpp>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace anogate::http {
namespace fs = std::filesystem;

std::string system_socket() { return std::string{runtime_folder} + "/control.sock"; }

Runner this_runner() {
    const char* runtime_dir = std::getenv("XDG_RUNTIME_DIR");
    return {geteuid() == 0 || access(runtime_folder, W_OK) == 0, runtime_dir != nullptr ? runtime_dir : ""};
}

std::optional<std::string> control_socket(const std::string& configured, const Runner& runner) {
    if (configured == "none") return std::nullopt;
    if (!configured.empty()) return configured;
    // If neither can be made, the error about the system's path is the more useful one.
    if (runner.system || runner.runtime_dir.empty()) return system_socket();
    return runner.runtime_dir + "/anogate.sock";
}

std::string socket_to_ask(const std::string& asked, const Runner& runner) {
    if (!asked.empty()) return asked;
    std::string usual = control_socket({}, runner).value_or(std::string{});
    std::error_code ec;
    return !fs::exists(usual, ec) && fs::exists(system_socket(), ec) ? system_socket() : usual;
}

std::string fault_of_socket(const std::string& path, const Runner& runner) {
    const std::string instead = " (use --control with another path, or --control none)";
    std::error_code ec;
    const fs::file_status there = fs::symlink_status(path, ec);
    if (fs::exists(there) && !fs::is_socket(there)) return path + ": exists and is not a socket" + instead;
    fs::path folder = folder_of(path);
    if (!fs::exists(folder, ec) && !ec) {
        if (!is_own_folder(folder, runner.runtime_dir)) return path + ": there is no folder " + folder.string() + instead;
        while (!fs::exists(folder, ec) && !ec && folder.has_relative_path()) folder = folder.parent_path();
    }
    if (fs::exists(folder, ec) && !fs::is_directory(folder, ec)) return error_text(path, ENOTDIR) + instead;
    if (::access(folder.c_str(), W_OK | X_OK) != 0) return error_text(path, errno) + instead;
    return {};
}

}    // namespace anogate::http
