#include <daemon/kept_config.hpp>
#include <daemon/kept_file.hpp>
#include <daemon/state_folder.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
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

}    // namespace

std::string kept_path(const std::string& what, const std::string& config_file) {
    const std::string folder = state_folder();
    if (folder.empty() || config_file.empty()) return {};
    std::error_code ec;
    const fs::path absolute = fs::weakly_canonical(fs::absolute(config_file, ec), ec);
    return folder + "/" + what + "-" + std::to_string(std::hash<std::string>{}(absolute.string()));
}

std::string kept_config_path(const std::string& config_file) { return kept_path("unconfirmed", config_file); }

bool have_same_texts(const std::vector<ConfigText>& one, const std::vector<ConfigText>& other) {
    const auto same = [](const ConfigText& a, const ConfigText& b) { return a.text == b.text; };
    return std::equal(one.begin(), one.end(), other.begin(), other.end(), same);
}

// Comments in the texts may contain any bytes; CBOR stores them unchanged.
std::string keep_config(const std::string& path, const KeptConfig& config) {
    const nlohmann::json all{{"unconfirmed", json_of(config.unconfirmed)}, {"confirmed", json_of(config.confirmed)}};
    return keep_file(path, nlohmann::json::to_cbor(all));
}

std::optional<KeptConfig> kept_config(const std::string& path) try {
    std::string fault;
    const auto bytes = read_kept_file(path, max_kept, fault);
    if (!bytes || bytes->empty()) return std::nullopt;
    const nlohmann::json all = nlohmann::json::from_cbor(*bytes);
    return KeptConfig{files_of(all.at("unconfirmed")), files_of(all.at("confirmed"))};
} catch (const nlohmann::json::exception&) {
    return std::nullopt;
}

std::string forget_config(const std::string& path) { return forget_file(path); }

}    // namespace anogate
