#include <sys/files/state_folder.hpp>

#include <cstdlib>

namespace anogate {
namespace {

std::string variable(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

}    // namespace

std::string state_folder() {
    if (const std::string given = variable("STATE_DIRECTORY"); !given.empty()) return given.substr(0, given.find(':'));
    if (const std::string state = variable("XDG_STATE_HOME"); !state.empty()) return state + "/anogate";
    if (const std::string home = variable("HOME"); !home.empty()) return home + "/.local/state/anogate";
    return {};
}

}    // namespace anogate
