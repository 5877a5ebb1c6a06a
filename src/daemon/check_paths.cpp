#include <daemon/check_paths.hpp>
#include <link/replay_settings.hpp>
#include <link/serial/port_identity.hpp>
#include <sys/files/own_folder.hpp>

#include <filesystem>

#include <net/if.h>

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

std::string fault_of_recordings(const std::string& folder) {
    std::error_code ec;
    const fs::file_status there = fs::status(folder, ec);
    if (ec == std::errc::not_a_directory) return "is below a file: nothing is recorded";
    return !fs::exists(there) || fs::is_directory(there) ? "" : "is not a folder: nothing is recorded";
}

// The map file may also be added while the program runs.
std::string fault_of_map(const std::string& file) {
    const fs::file_type there = type_of(file);
    if (there == fs::file_type::not_found) return "not found: the page shows a grid";
    return there == fs::file_type::regular || there == fs::file_type::none ? "" : "is not a regular file: the page shows a grid";
}

// By its name or its number.
bool has_interface(const std::string& name) {
    char of_number[IF_NAMESIZE];
    const bool is_number = name.find_first_not_of("0123456789") == std::string::npos && name.size() < 10;
    return ::if_nametoindex(name.c_str()) != 0 ||
           (is_number && ::if_indextoname(static_cast<unsigned>(std::stoul(name)), of_number) != nullptr);
}

void warn_of_interface(Draft& draft, const Origin& origin, std::string_view key, const std::string& name) {
    if (name.empty() || has_interface(name)) return;
    draft.warnings.push_back({origin.key(key), "warning: network interface " + in_quotes(name) +
                                                   " not found: the link waits for it; `ip link` lists the interfaces"});
}

// Of link-local addresses. The interface of the key `interface` may be a VPN, which comes up later.
void warn_of_interfaces(Draft& draft) {
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i) {
        const LinkSettings& link = draft.settings.links[i];
        if (draft.links[i].broken) continue;
        if (const auto peer = link.kind->connects_to ? link.kind->connects_to(link) : std::nullopt)
            warn_of_interface(draft, draft.links[i], peer->key, peer->peer.interface);
        if (const auto bound = link.kind->bound_port ? link.kind->bound_port(link) : std::nullopt)
            warn_of_interface(draft, draft.links[i], bound->key, bound->local.interface);
    }
}

// The first enabled one of `all` before `i` that leads to the same device by another name; nullptr: none.
const NamedPath* same_device_before(const std::vector<NamedPath>& all, std::size_t i) {
    const auto device_at = [](const LinkPath& of) {
        std::error_code ec;
        return of.is_made ? fs::path{} : fs::canonical(of.path, ec);
    };
    const fs::path device = device_at(all[i].path);
    for (std::size_t j = 0; j < i && !device.empty(); ++j)
        if (all[j].is_enabled && all[j].path.path != all[i].path.path && device_at(all[j].path) == device) return &all[j];
    return nullptr;
}

void warn(Draft& draft, const Origin& origin, std::string_view key, const std::string& path, const std::string& fault) {
    if (!fault.empty())
        draft.warnings.push_back({origin.key(key), "warning: " + in_quotes(key) + " " + in_quotes(path) + ": " + fault});
}

}    // namespace

void warn_of_paths(Draft& draft) {
    warn_of_interfaces(draft);
    const std::vector<NamedPath> paths = paths_of_links(draft);
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const auto& [of, key, origin, is_enabled] = paths[i];
        warn(draft, origin, key, of.path, of.is_made ? fault_of_pty(of.path) : fault_of_device(of));
        if (const NamedPath* const same = is_enabled ? same_device_before(paths, i) : nullptr)
            warn(draft, origin, key, of.path,
                 "is the same device as " + in_quotes(same->path.path) + " of another link; only one link can open it");
    }
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i) {
        const LinkSettings& link = draft.settings.links[i];
        if (!link.kind->replays || draft.links[i].broken) continue;
        const std::string& file = link.as<ReplaySettings>().file;
        warn(draft, draft.links[i], "file", file, fault_of_recording(file));
    }
    if (const std::string& file = draft.settings.log.file; !file.empty())
        warn(draft, draft.log, "file", file, fault_of_log(file));
    if (const auto& record = draft.settings.record; record && !record->folder.empty())
        warn(draft, draft.record, "folder", record->folder, fault_of_recordings(record->folder));
    if (const std::string& file = draft.settings.control.map.file; !file.empty())
        warn(draft, draft.control, "map/file", file, fault_of_map(file));
}

}    // namespace anogate
