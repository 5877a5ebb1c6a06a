#include <daemon/check_paths.hpp>
#include <link/replay_settings.hpp>
#include <link/serial/port_identity.hpp>
#include <sys/files/own_folder.hpp>

#include <filesystem>

namespace anogate {
namespace {

namespace fs = std::filesystem;

fs::file_type type_of(const std::string& path) {
    std::error_code ec;
    return fs::status(path, ec).type();
}

std::string fault_of_pty(const std::string& path) {
    if (const auto folder = check_folder_of(path); !folder)
        return folder.error() + ": anogated waits for it and does not create it";
    return is_taken(path) ? "another file exists there and is left alone; choose another path" : "";
}

std::string fault_of_log(const std::string& path) {
    constexpr char instead[] = ": logging to standard error";
    if (const auto folder = check_folder_of(path); !folder) return folder.error() + instead;
    const fs::file_type there = type_of(path);
    if (there == fs::file_type::directory) return std::string{"is a folder"} + instead;
    return there == fs::file_type::fifo ? std::string{"is a pipe"} + instead : "";
}

std::string fault_of_device(const LinkPath& of) {
    const fs::file_type there = type_of(of.path);
    const std::string noun{of.noun};
    if (there == fs::file_type::directory) return "is a folder; give the path of the " + noun;
    if (there == fs::file_type::regular) return "is a regular file, not a " + noun + "; `anoctl ports` lists the devices";
    return fault_of_by_id("/", of.path);
}

std::string fault_of_recording(const std::string& file) {
    const fs::file_type there = type_of(file);
    if (there == fs::file_type::not_found) return "not found; anogated waits for it";
    return there == fs::file_type::regular || there == fs::file_type::none ? "" : "is not a regular file";
}

// The map file may also be added while the program runs.
std::string fault_of_map(const std::string& file) {
    const fs::file_type there = type_of(file);
    if (there == fs::file_type::not_found) return "not found: the page shows a grid";
    return there == fs::file_type::regular || there == fs::file_type::none ? "" : "is not a regular file: the page shows a grid";
}

void warn(Draft& draft, const Origin& origin, std::string_view key, const std::string& path, const std::string& fault) {
    if (!fault.empty())
        draft.warnings.push_back({origin.key(key), "warning: " + in_quotes(key) + " " + in_quotes(path) + ": " + fault});
}

}    // namespace

void warn_of_paths(Draft& draft) {
    for (const NamedPath& named : paths_of_links(draft)) {
        const std::string& path = named.path.path;
        warn(draft, named.origin, named.key, path, named.path.is_made ? fault_of_pty(path) : fault_of_device(named.path));
    }
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i) {
        const LinkSettings& link = draft.settings.links[i];
        if (!link.kind->replays || draft.links[i].broken) continue;
        const std::string& file = link.as<ReplaySettings>().file;
        warn(draft, draft.links[i], "file", file, fault_of_recording(file));
    }
    if (const std::string& file = draft.settings.log.file; !file.empty())
        warn(draft, draft.log, "file", file, fault_of_log(file));
    if (const std::string& file = draft.settings.control.map.file; !file.empty())
        warn(draft, draft.control, "map/file", file, fault_of_map(file));
}

}    // namespace anogate
