#include "kept_values.hpp"

#include "file_text.hpp"

#include <anoctl/anoctl.hpp>

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace anoctl {
namespace {

namespace fs = std::filesystem;

fs::path state_folder() {
    if (const char* const state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state == '/')
        return fs::path{state} / "anogate";
    const char* const home = std::getenv("HOME");
    return home != nullptr && *home != '\0' ? fs::path{home} / ".local/state/anogate" : fs::path{};
}

}    // namespace

bool is_in_state_folder(const std::string& path) {
    std::error_code error;
    const fs::path folder = state_folder();
    return !folder.empty() && fs::equivalent(fs::absolute(path, error).parent_path(), folder, error);
}

std::string keep_in_state_folder(const std::string& name, const std::string& text) {
    const fs::path folder = state_folder();
    if (folder.empty()) return "neither XDG_STATE_HOME nor HOME says where";
    const fs::path path = folder / name;
    std::error_code error;
    if (text.empty()) {
        fs::remove(path, error);
        return error ? path.string() + ": it can't be removed: " + error.message() : std::string{};
    }
    if (fs::exists(path, error))
        return path.string() + " has those of a calibration that did not end: write them back by anoctl param import " +
               path.string() + " and anoctl param save, then remove it";
    fs::create_directories(folder, error);
    if (error) return folder.string() + ": it can't be made: " + error.message();
    try {
        write_file(path.string(), text);
    } catch (const Failure& e) {
        return e.what();
    }
    return {};
}

}    // namespace anoctl
