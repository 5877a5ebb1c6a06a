#include <config/read_file.hpp>
#include <daemon/kept_config.hpp>
#include <daemon/state_folder.hpp>
#include <link/errors.hpp>
#include <link/unique_fd.hpp>

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <functional>

namespace anogate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_kept = 64 << 20;

nlohmann::json json_of(const std::vector<ConfigText>& files) {
    nlohmann::json list = nlohmann::json::array();
    for (const ConfigText& file : files) list.push_back({{"file", file.file}, {"text", file.text}});
    return list;
}

std::vector<ConfigText> files_of(const nlohmann::json& list) {
    std::vector<ConfigText> files;
    for (const nlohmann::json& file : list)
        files.push_back({file.at("file").get<std::string>(), file.at("text").get<std::string>()});
    return files;
}

bool write_all(int fd, const std::vector<std::uint8_t>& bytes) {
    for (std::size_t at = 0; at < bytes.size();) {
        const ssize_t n = ::write(fd, bytes.data() + at, bytes.size() - at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += static_cast<std::size_t>(n);
    }
    return ::fsync(fd) == 0;
}

bool sync_folder(const fs::path& file) {
    const UniqueFd folder{::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    return folder && ::fsync(folder.get()) == 0;
}

}    // namespace

std::string kept_config_path(const std::string& config_file) {
    const std::string folder = state_folder();
    if (folder.empty() || config_file.empty()) return {};
    std::error_code ec;
    const fs::path absolute = fs::weakly_canonical(fs::absolute(config_file, ec), ec);
    return folder + "/unconfirmed-" + std::to_string(std::hash<std::string>{}(absolute.string()));
}

bool have_same_texts(const std::vector<ConfigText>& one, const std::vector<ConfigText>& other) {
    const auto same = [](const ConfigText& a, const ConfigText& b) { return a.text == b.text; };
    return std::equal(one.begin(), one.end(), other.begin(), other.end(), same);
}

// Texts may hold any bytes in their comments: CBOR takes them as they are.
std::string keep_config(const std::string& path, const KeptConfig& config) {
    if (path.empty()) return "there is no folder for it ($STATE_DIRECTORY, $XDG_STATE_HOME and $HOME are not set)";
    std::error_code ec;
    fs::create_directories(fs::path{path}.parent_path(), ec);
    if (ec) return error_text(fs::path{path}.parent_path().string(), ec.value());
    const std::string unfinished = path + ".new";
    const nlohmann::json all{{"unconfirmed", json_of(config.unconfirmed)}, {"confirmed", json_of(config.confirmed)}};
    const UniqueFd file{::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600)};
    if (file && write_all(file.get(), nlohmann::json::to_cbor(all)) && std::rename(unfinished.c_str(), path.c_str()) == 0 &&
        sync_folder(path))
        return {};
    return error_text(path, errno);
}

std::optional<KeptConfig> kept_config(const std::string& path) try {
    std::error_code error;
    const std::string bytes = path.empty() ? "" : read_file(path, max_kept, error);
    if (error || bytes.empty()) return std::nullopt;
    const nlohmann::json all = nlohmann::json::from_cbor(bytes);
    return KeptConfig{files_of(all.at("unconfirmed")), files_of(all.at("confirmed"))};
} catch (const nlohmann::json::exception&) {
    return std::nullopt;
}

std::string forget_config(const std::string& path) {
    if (path.empty() || ::unlink(path.c_str()) == 0) {
        if (!path.empty()) sync_folder(path);
        return {};
    }
    return errno == ENOENT || errno == ENOTDIR ? "" : error_text(path, errno);
}

}    // namespace anogate
