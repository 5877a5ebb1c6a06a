#include <daemon/service.hpp>
#include <sys/files/own_folder.hpp>

#include <algorithm>
#include <filesystem>
#include <span>

#include <pwd.h>
#include <unistd.h>

namespace anogate {
namespace {

namespace fs = std::filesystem;

// log_folder: LogsDirectory= of the unit. /dev is visible to the service, and all users may write to /dev/shm.
constexpr char log_folder[] = "/var/log/anogate";
constexpr const char* service_folders[] = {runtime_folder, log_folder, "/dev/shm"};
constexpr char service_state_folder[] = "/var/lib/anogate";    // StateDirectory=

/// /run/anogate-NAME for anogated@NAME.service, whose configuration is NAME.json.
std::string runtime_folder_for(const std::string& config_file) {
    const std::string name = fs::path{config_file}.stem().string();
    return name.empty() || name == "anogate" ? runtime_folder : std::string{runtime_folder} + "-" + name;
}

bool is_below(const fs::path& path, const fs::path& folder) {
    const fs::path step = path.lexically_relative(folder);
    return !step.empty() && *step.begin() != ".." && step != ".";
}

// PrivateTmp= of the unit: the service has private ones, which are empty and read-only.
constexpr const char* private_folders[] = {"/tmp", "/var/tmp"};

/// Resolves symbolic links in its folder, because /var/run is /run; but not the last part, which may be a link that will be
/// replaced.
fs::path looked_up(const std::string& path) {
    std::error_code ec;
    const fs::path absolute = fs::path{"/"} / path;    // the service starts in /
    fs::path folder = fs::weakly_canonical(absolute.parent_path(), ec);
    if (ec) folder = absolute.parent_path().lexically_normal();
    return folder / absolute.filename();
}

bool is_below_one_of(const fs::path& path, std::span<const char* const> folders) {
    return std::any_of(folders.begin(), folders.end(), [&](const char* folder) { return is_below(path, folder); });
}

struct ServiceFolders {
    std::string runtime;    // runtime folder of this instance
    Draft& draft;
};

void check_writable(const std::string& path, std::string_view key, const std::string& where, const std::string& better,
                    const ServiceFolders& service) {
    const fs::path there = looked_up(path);
    if (path.empty() || is_below_one_of(there, service_folders) || is_below(there, service.runtime)) return;
    const bool unseen = is_below_one_of(there, private_folders);
    service.draft.errors.push_back(
        {where, in_quotes(key) + " " + in_quotes(path) + ": the service has no write access there" +
                    (unseen ? ", and its /tmp is private; " : "; ") + better + "/" + fs::path{path}.filename().string() +
                    " works" + (unseen ? "" : " (to allow another folder: systemctl edit anogated, ReadWritePaths=FOLDER)")});
}

void check_port(const std::string& device, const std::string& where, Draft& draft) {
    if (is_below_one_of(looked_up(device), private_folders))
        draft.errors.push_back({where, "'device' " + in_quotes(device) +
                                           ": the service has its own private /tmp; create the port in another folder, "
                                           "such as /run (or: systemctl edit anogated, PrivateTmp=no)"});
}

}    // namespace

bool is_for_service(const std::string& config_file, const std::string& default_file) {
    if (const passwd* user = ::getpwuid(::geteuid()); user && std::string_view{user->pw_name} == "anogate") return true;
    if (config_file.empty()) return false;
    std::error_code ec;
    const auto folder_of = [&](const std::string& file) {
        return fs::weakly_canonical(fs::absolute(file, ec), ec).parent_path();
    };
    const fs::path folder = folder_of(config_file);
    return !ec && folder == folder_of(default_file);
}

void check_for_service(Draft& draft, const std::string& config_file) {
    const ServiceFolders service{runtime_folder_for(config_file), draft};
    for (const auto& [path, key, origin, is_enabled] : paths_of_links(draft)) {
        if (path.is_made) check_writable(path.path, key, origin.key(key), service.runtime, service);
        else check_port(path.path, origin.key(key), draft);
    }
    check_writable(draft.settings.log.file, "file", draft.log.key("file"), log_folder, service);
    const ControlSettings& control = draft.settings.control;
    std::error_code ec;
    if (control.http && !is_below(looked_up(control.token_file), service_state_folder) &&
        !fs::exists(looked_up(control.token_file), ec) && !ec)    // an existing file is only read
        check_writable(control.token_file, "token_file", draft.control.key("token_file"), service_state_folder, service);
    if (draft.settings.record && !draft.settings.record->folder.empty() &&
        !is_below(looked_up(draft.settings.record->folder), service_state_folder))
        check_writable(draft.settings.record->folder, "folder", draft.record.key("folder"), service_state_folder, service);
    if (control.socket != "none") check_writable(control.socket, "socket", draft.control.key("socket"), service.runtime, service);
}

}    // namespace anogate
