#include <config/read_files.hpp>
#include <sys/files/read_file.hpp>

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace anogate {
namespace {

namespace fs = std::filesystem;

bool read_into(std::vector<ConfigText>& files, const std::string& file, ConfigErrors& errors) {
    std::error_code error;
    std::string text = read_file(file, max_config_size, error);
    if (!error) return files.push_back({file, std::move(text)}), true;
    errors.push_back({file, error == std::errc::file_too_large            ? "larger than 1 MiB, not a configuration"
                            : error == std::errc::operation_not_supported ? "is not a regular file but a pipe, socket or device"
                                                                          : error.message()});
    return false;
}

/// Excludes folders, and backup and temporary files of editors: their names do not end in .json, or begin with a dot. Pipes,
/// sockets and devices are included by any name, so that they are reported.
bool is_part(const fs::directory_entry& entry) {
    std::error_code ec;
    if (entry.path().filename().string().starts_with('.')) return false;
    return entry.path().extension() == ".json" || entry.is_other(ec);
}

std::vector<std::string> parts_in(const fs::path& folder, ConfigErrors& errors) {
    std::vector<std::string> parts;
    std::error_code ec;
    for (fs::directory_iterator entry{folder, ec}; !ec && entry != fs::directory_iterator{}; entry.increment(ec))
        if (is_part(*entry)) parts.push_back(entry->path().string());
    std::error_code ignored;
    const bool is_absent = ec == std::errc::no_such_file_or_directory && !fs::is_symlink(folder, ignored);
    if (ec && !is_absent) errors.push_back({folder.string(), ec.message()});
    std::sort(parts.begin(), parts.end());
    return parts;
}

}    // namespace

std::vector<ConfigText> read_config_file(const std::string& file, ConfigErrors& errors) {
    std::vector<ConfigText> files;
    read_into(files, file, errors);
    return files;
}

std::vector<ConfigText> read_config_files(const std::string& file, ConfigErrors& errors) {
    std::vector<ConfigText> files;
    if (!read_into(files, file, errors)) return files;
    for (const std::string& part : parts_in(fs::path{file}.parent_path() / "conf.d", errors)) read_into(files, part, errors);
    return files;
}

void read_config(const std::vector<ConfigText>& files, Draft& draft) {
    for (const ConfigText& file : files) read_config(file.text, file.file, draft);
}

}    // namespace anogate
