#include <sys/errors.hpp>
#include <sys/files/own_folder.hpp>

#include <cstdlib>

namespace anogate {
namespace fs = std::filesystem;
namespace {

bool is_at_or_below(const fs::path& path, const fs::path& folder) {
    const fs::path step = path.lexically_normal().lexically_relative(folder);
    return !step.empty() && *step.begin() != "..";
}

bool is_own(const fs::path& folder) {
    const char* runtime_dir = std::getenv("XDG_RUNTIME_DIR");
    return is_own_folder(folder, runtime_dir ? runtime_dir : "");
}

}    // namespace

bool is_own_folder(const fs::path& folder, const std::string& runtime_dir) {
    for (const char* const own : {runtime_folder, "/var/log/anogate"})
        if (is_at_or_below(folder, own)) return true;
    if (folder.lexically_normal().string().starts_with(std::string{runtime_folder} + "-")) return true;
    return !runtime_dir.empty() && (folder == runtime_dir || is_at_or_below(folder, fs::path{runtime_dir} / "anogate"));
}

fs::path folder_of(const fs::path& path) {
    const fs::path folder = path.parent_path();
    return folder.empty() ? "." : folder;
}

Expected<void> make_folder_of(const fs::path& path) {
    const fs::path folder = folder_of(path);
    std::error_code ec;
    if (is_own(folder)) fs::create_directories(folder, ec);
    if (ec) return Unexpected{error_text(path.string(), ec.value())};
    if (!fs::exists(folder, ec) && !ec) return Unexpected{path.string() + ": there is no folder " + folder.string()};
    return {};
}

Expected<void> check_folder_of(const fs::path& path) {
    const fs::path folder = folder_of(path);
    std::error_code ec;
    const fs::file_type there = fs::status(folder, ec).type();
    if (is_own(folder) || there == fs::file_type::directory || there == fs::file_type::none || there == fs::file_type::unknown)
        return {};
    return Unexpected{there == fs::file_type::not_found ? "there is no folder " + folder.string()
                                                        : folder.string() + " is not a folder"};
}

bool is_taken(const fs::path& path) {
    std::error_code ec;
    const fs::file_status there = fs::symlink_status(path, ec);
    if (!fs::exists(there)) return false;
    return !fs::is_symlink(there) || fs::read_symlink(path, ec).parent_path() != "/dev/pts";
}

}    // namespace anogate
