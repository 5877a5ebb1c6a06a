#include "prometheus_text.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

namespace anoctl {
namespace {

using ano::Json;

/// The text before `end`; removes both from `rest`. std::nullopt: `end` is missing.
std::optional<std::string> read_until(std::string_view& rest, char end) {
    const auto at = rest.find(end);
    if (at == std::string_view::npos) return std::nullopt;
    std::string word{rest.substr(0, at)};
    rest.remove_prefix(at + 1);
    return word;
}

/// A label value up to its closing quotation mark.
std::optional<std::string> read_value(std::string_view& rest) {
    std::string value;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        if (rest[i] == '"') {
            rest.remove_prefix(i + 1);
            return value;
        }
        const bool escaped = rest[i] == '\\' && i + 1 < rest.size();
        if (escaped) ++i;
        value += escaped && rest[i] == 'n' ? '\n' : rest[i];
    }
    return std::nullopt;
}

// `rest` begins after '{'; everything up to '}' is removed.
std::optional<Json> read_labels(std::string_view& rest) {
    Json labels = Json::object();
    while (!rest.starts_with('}')) {
        const auto name = read_until(rest, '=');
        if (!name || !rest.starts_with('"')) return std::nullopt;
        rest.remove_prefix(1);
        auto value = read_value(rest);
        if (!value || rest.empty()) return std::nullopt;
        labels[*name] = std::move(*value);
        if (rest.starts_with(',')) rest.remove_prefix(1);
    }
    rest.remove_prefix(1);
    return labels;
}

// NaN and Inf are not JSON numbers, and some programs can't read integers beyond 2^53: these remain text.
Json value_of(const std::string& word) {
    constexpr std::uint64_t max_exact = std::uint64_t{1} << 53;
    Json number = Json::parse(word, nullptr, false);
    if (!number.is_number() || (number.is_number_unsigned() && number.get<std::uint64_t>() > max_exact)) return word;
    return number;
}

std::optional<Json> sample_of(std::string_view line) {
    const auto end = std::min(line.find_first_of("{ "), line.size());
    Json sample{{"name", line.substr(0, end)}, {"labels", Json::object()}};
    line.remove_prefix(end);
    if (line.starts_with('{')) {
        line.remove_prefix(1);
        auto labels = read_labels(line);
        if (!labels) return std::nullopt;
        sample["labels"] = std::move(*labels);
    }
    if (!line.starts_with(' ') || line.size() < 2) return std::nullopt;
    sample["value"] = value_of(std::string{line.substr(1)});
    return sample;
}

}    // namespace

std::vector<Json> samples_of(std::string_view text) {
    std::vector<Json> samples;
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        if (line.empty() || line.starts_with('#')) continue;
        if (auto sample = sample_of(line)) samples.push_back(std::move(*sample));
    }
    return samples;
}

}    // namespace anoctl
