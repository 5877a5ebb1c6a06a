#include "kept_values.hpp"

#include "file_text.hpp"

#include <anoctl/anoctl.hpp>
#include <devices/works/calibration_work.hpp>
#include <sys/files/read_file.hpp>

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace anoctl {
namespace {

namespace fs = std::filesystem;

// The folder in the environment variable `variable`, else `in_home` in the home folder; with "anogate" appended. Empty: neither
// is set.
fs::path user_folder(const char* variable, const char* in_home) {
    if (const char* const folder = std::getenv(variable); folder != nullptr && *folder == '/')
        return fs::path{folder} / "anogate";
    const char* const home = std::getenv("HOME");
    return home != nullptr && *home != '\0' ? fs::path{home} / in_home / "anogate" : fs::path{};
}

fs::path state_folder() { return user_folder("XDG_STATE_HOME", ".local/state"); }
fs::path cache_folder() { return user_folder("XDG_CACHE_HOME", ".cache"); }

constexpr std::size_t max_cached = 8 * 1024 * 1024;    // bytes
constexpr std::size_t max_kept = 64 * 1024;            // bytes

}    // namespace

std::string cached_text(const std::string& name) {
    const fs::path folder = cache_folder();
    std::error_code error;
    std::string text = folder.empty() ? std::string{} : anogate::read_file((folder / name).string(), max_cached, error);
    return error ? std::string{} : text;
}

void cache_text(const std::string& name, const std::string& text) {
    const fs::path folder = cache_folder();
    std::error_code error;
    if (folder.empty() || (fs::create_directories(folder, error), error)) return;
    try {
        write_file((folder / name).string(), text);
    } catch (const Failure&) {    // not an error: the data is read from the device again
    }
}

bool is_in_state_folder(const std::string& path) {
    std::error_code error;
    const fs::path folder = state_folder();
    return !folder.empty() && fs::equivalent(fs::absolute(path, error).parent_path(), folder, error);
}

std::map<std::string, std::string> texts_in_state_folder(bool (*wanted)(std::string_view name)) {
    std::map<std::string, std::string> all;
    std::error_code error;
    const fs::path folder = state_folder();
    if (folder.empty()) return all;
    for (const auto& entry : fs::directory_iterator{folder, error}) {
        const std::string name = entry.path().filename().string();
        if (!wanted(name)) continue;
        std::error_code unread;
        std::string text = anogate::read_file(entry.path().string(), max_kept, unread);
        if (!unread) all.emplace(name, std::move(text));
    }
    return all;
}

std::string path_in_state_folder(const std::string& name) { return (state_folder() / name).string(); }

std::string keep_in_state_folder(const std::string& name, const std::string& text, Earlier earlier) {
    const fs::path folder = state_folder();
    if (folder.empty()) return "neither XDG_STATE_HOME nor HOME is set";
    const fs::path path = folder / name;
    std::error_code error;
    if (text.empty()) {
        fs::remove(path, error);
        return error ? path.string() + ": cannot remove: " + error.message() : std::string{};
    }
    if (earlier == Earlier::stays && fs::exists(path, error) && anogate::sensor_of_note(name))
        return path.string() + " contains the old values of an interrupted calibration; restore them with anoctl param import " +
               path.string() + " and anoctl param save, then remove the file";
    fs::create_directories(folder, error);
    if (error) return folder.string() + ": cannot create: " + error.message();
    try {
        write_file(path.string(), text);
    } catch (const Failure& e) {
        return e.what();
    }
    return {};
}

}    // namespace anoctl
