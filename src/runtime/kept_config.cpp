#include <runtime/kept_config.hpp>
#include <sys/files/state_folder.hpp>
#include <sys/files/write_atomically.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
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

namespace {

constexpr std::size_t max_depth = 8;    // more than a stored configuration has

/// Reads the head of a CBOR item (RFC 8949, 3.): its major type and argument. std::nullopt: it is truncated, or of indefinite
/// length.
struct CborHead {
    unsigned major = 0;
    std::uint64_t argument = 0;
};
std::optional<CborHead> read_head(std::string_view& bytes) {
    constexpr unsigned one_byte = 24, last_size = 27;
    if (bytes.empty()) return std::nullopt;
    const unsigned first = static_cast<std::uint8_t>(bytes[0]);
    const unsigned info = first & 31u;
    bytes.remove_prefix(1);
    if (info < one_byte) return CborHead{first >> 5u, info};
    const std::size_t size = std::size_t{1} << (info - one_byte);
    if (info > last_size || bytes.size() < size) return std::nullopt;
    CborHead head{first >> 5u, 0};
    for (const char byte : bytes.substr(0, size)) head.argument = head.argument << 8 | static_cast<std::uint8_t>(byte);
    bytes.remove_prefix(size);
    return head;
}

/// Whether the library may parse the bytes. It parses nested items recursively, including strings of indefinite length (never
/// written by us), and could overflow the stack. True: the bytes are one complete item with at most max_depth levels.
bool is_shallow_cbor(std::string_view bytes) {
    enum Major : unsigned { byte_string = 2, text_string = 3, array = 4, map = 5, tag = 6 };
    std::array<std::uint64_t, max_depth> left{};    // number of missing items, by depth
    std::size_t depth = 0;
    do {
        const auto head = read_head(bytes);
        if (!head || head->major == tag) return false;
        const std::uint64_t argument = head->argument;
        if (head->major >= byte_string && head->major <= map && argument > bytes.size()) return false;
        if (head->major == byte_string || head->major == text_string) bytes.remove_prefix(static_cast<std::size_t>(argument));
        if ((head->major == array || head->major == map) && argument > 0) {
            if (depth == max_depth) return false;
            left[depth++] = head->major == map ? 2 * argument : argument;
            continue;
        }
        while (depth > 0 && --left[depth - 1] == 0) --depth;
    } while (depth > 0);
    return bytes.empty();
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
    return write_atomically(path, nlohmann::json::to_cbor(all));
}

std::optional<KeptConfig> parse_kept_config(std::string_view bytes) try {
    if (!is_shallow_cbor(bytes)) return std::nullopt;
    const nlohmann::json all = nlohmann::json::from_cbor(bytes);
    return KeptConfig{files_of(all.at("unconfirmed")), files_of(all.at("confirmed"))};
} catch (const nlohmann::json::exception&) {
    return std::nullopt;
}

std::optional<KeptConfig> kept_config(const std::string& path, std::string& fault) {
    const auto bytes = read_kept_file(path, max_kept, fault);
    auto kept = bytes ? parse_kept_config(*bytes) : std::nullopt;
    if (bytes && !kept) fault = path + ": damaged; remove it";
    return kept;
}

std::string forget_config(const std::string& path) { return forget_file(path); }

}    // namespace anogate
