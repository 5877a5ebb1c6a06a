#include <daemon/key_facts.hpp>
#include <daemon/service.hpp>

#include <filesystem>

#include <pwd.h>
#include <unistd.h>

namespace anogate {
namespace {

namespace fs = std::filesystem;

// RuntimeDirectory= and LogsDirectory= of the unit; /dev is left as it is, and there everybody may write to /dev/shm.
constexpr char runtime_folder[] = "/run/anogate";
constexpr char log_folder[] = "/var/log/anogate";
constexpr const char* writable[] = {runtime_folder, log_folder, "/dev/shm"};

bool is_below(const fs::path& path, const fs::path& folder) {
    const fs::path step = path.lexically_relative(folder);
    return !step.empty() && *step.begin() != ".." && step != ".";
}

/// Its folder is looked up, for /var/run is /run; the last part may be a link that is replaced.
bool service_writes(const std::string& path) {
    std::error_code ec;
    const fs::path absolute = fs::path{"/"} / path;    // the service starts in /
    fs::path folder = fs::weakly_canonical(absolute.parent_path(), ec);
    if (ec) folder = absolute.parent_path().lexically_normal();
    for (const char* const one : writable)
        if (is_below(folder / absolute.filename(), one)) return true;
    return false;
}

void judge(const std::string& path, std::string_view key, const std::string& where, const char* better, Draft& draft) {
    if (path.empty() || service_writes(path)) return;
    draft.errors.push_back({where, in_quotes(key) + " " + in_quotes(path) + ": the service may not write there; " + better + "/" +
                                       fs::path{path}.filename().string() +
                                       " works (for another folder: systemctl edit anogated, ReadWritePaths=FOLDER)"});
}

}  // namespace

bool is_for_service(const std::string& config_file, const std::string& default_file) {
    if (const passwd* user = ::getpwuid(::geteuid()); user && std::string_view{user->pw_name} == "anogate") return true;
    if (config_file.empty()) return false;
    std::error_code ec;
    const auto folder_of = [&](const std::string& file) { return fs::weakly_canonical(fs::absolute(file, ec), ec).parent_path(); };
    const fs::path folder = folder_of(config_file);
    return !ec && folder == folder_of(default_file);
}

void judge_for_service(Draft& draft) {
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i)
        if (const LinkSettings& link = draft.settings.links[i]; link.kind == "pty" && !draft.links[i].broken)
            judge(link.pty.path, "path", draft.links[i].key("path"), runtime_folder, draft);
    judge(draft.settings.log.file, "file", draft.log.key("file"), log_folder, draft);
    if (draft.settings.control.socket != "none")
        judge(draft.settings.control.socket, "socket", draft.control.key("socket"), runtime_folder, draft);
}

}  // namespace anogate
