#include <ano/address.hpp>
#include <ano/traffic.hpp>
#include <ano_json/strict_json.hpp>
#include <managed/managed_parameters.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::Type;

constexpr std::size_t max_name = 20;
constexpr double max_per_second = 10'000;
constexpr std::chrono::milliseconds min_memory{1000}, max_memory{24 * 3600 * 1000};

constexpr std::array<std::string_view, 5> levels{"trace", "debug", "info", "warn", "error"};

double level_of(const Settings& s, const LinkSettings&) {
    return static_cast<double>(std::find(levels.begin(), levels.end(), s.log.level) - levels.begin());
}
void set_level(Settings& s, LinkSettings&, double value) { s.log.level = levels[static_cast<std::size_t>(value)]; }
std::string level_text(const Settings& s, const LinkSettings&) { return s.log.level; }

double memory_of(const Settings& s, const LinkSettings&) {
    return static_cast<double>(std::chrono::duration_cast<std::chrono::milliseconds>(s.gateway.forget_after).count());
}
void set_memory(Settings& s, LinkSettings&, double value) {
    s.gateway.forget_after = std::chrono::milliseconds{static_cast<std::int64_t>(value)};
}
std::string memory_text(const Settings& s, const LinkSettings& link) {
    return std::to_string(static_cast<std::int64_t>(memory_of(s, link))) + "ms";
}

// For Unknown::link, the link is the one in the file.
double unknown_of(const Settings& s, const LinkSettings&) { return static_cast<double>(s.gateway.unknown); }
void set_unknown_choice(Settings& s, LinkSettings&, double value) {
    s.gateway.unknown = static_cast<Unknown>(static_cast<std::uint8_t>(value));
    if (s.gateway.unknown != Unknown::link) s.gateway.unknown_link.clear();
}
std::string unknown_text(const Settings& s, const LinkSettings&) {
    if (s.gateway.unknown == Unknown::link) return "link " + s.gateway.unknown_link;
    return s.gateway.unknown == Unknown::flood ? "flood" : "drop";
}

double enabled_of(const Settings&, const LinkSettings& link) { return link.enabled ? 1 : 0; }
void set_enabled(Settings&, LinkSettings& link, double value) { link.enabled = value != 0; }
std::string enabled_text(const Settings&, const LinkSettings& link) { return link.enabled ? "yes" : "no"; }

bool is_telemetry(std::uint8_t id) { return ano::traffic_class_of(id) == ano::TrafficClass::telemetry; }

// 0: the limits of the file for each message apply. Above 0: the maximum for every message of telemetry.
double no_limit_of_its_own(const Settings&, const LinkSettings&) { return 0; }
void set_rate_limit(Settings&, LinkSettings& link, double value) {
    if (value <= 0) return;
    std::vector<LimitRule>& rules = link.rules.limit;
    for (unsigned n = 0; n <= UINT8_MAX; ++n) {
        const auto id = static_cast<std::uint8_t>(n);
        if (!is_telemetry(id)) continue;
        const auto of_id = std::find_if(rules.begin(), rules.end(), [id](const LimitRule& rule) { return rule.id == id; });
        if (of_id == rules.end()) rules.push_back({id, value});
        else of_id->per_second = std::min(of_id->per_second, value);
    }
}
std::string limit_text_of(const Settings&, const LinkSettings& link) {
    std::map<std::uint8_t, double> sorted;
    for (const LimitRule& rule : link.rules.limit)
        if (is_telemetry(rule.id)) sorted[rule.id] = rule.per_second;
    std::string words;
    for (const auto& [id, per_second] : sorted) words += std::to_string(id) + "=" + std::to_string(per_second) + " ";
    return words;
}

/// A name of at most 20 bytes, without an incomplete character, that is not in `taken`.
std::string short_name(const std::string& beginning, const std::string& link, std::set<std::string>& taken) {
    std::string name = cut_text(beginning + link, max_name);
    for (int n = 2; !taken.insert(name).second; ++n) {
        const std::string number = "~" + std::to_string(n);
        name = cut_text(beginning + link, max_name - number.size()) + number;
    }
    return name;
}

const LinkSettings* link_of(const Settings& settings, const std::string& name) {
    const auto found = std::find_if(settings.links.begin(), settings.links.end(),
                                    [&](const LinkSettings& link) { return link.name == name; });
    return found == settings.links.end() ? nullptr : &*found;
}

/// std::nullopt: no such link.
std::optional<std::string> value_text_in(const Settings& settings, const ManagedParameter& row) {
    const LinkSettings none;
    if (row.link.empty()) return row.words(settings, none);
    const LinkSettings* const link = link_of(settings, row.link);
    return link ? std::optional{row.words(settings, *link)} : std::nullopt;
}

}    // namespace

bool is_device(const GatewaySettings& gateway) noexcept {
    return gateway.id != ano::address::unassigned && gateway.id != ano::address::broadcast && !ano::address::is_host(gateway.id);
}

std::string cut_text(const std::string& text, std::size_t max_bytes) {
    std::size_t size = std::min(text.size(), max_bytes);
    while (size > 0 && size < text.size() && (static_cast<unsigned char>(text[size]) & 0xC0) == 0x80) --size;
    return text.substr(0, size);
}

std::vector<ManagedParameter> managed_parameters(const Settings& of_file) {
    const bool names_a_link = of_file.gateway.unknown == Unknown::link;
    std::vector<ManagedParameter> rows{
        {"log/level",
         "LOG_LEVEL",
         "lowest log level: 0 trace, 1 debug, 2 info, 3 warn, 4 error",
         Type::u8,
         0,
         4,
         {},
         level_of,
         set_level,
         level_text},
        {"gateway/forget_after",
         "FORGET_AFTER",
         "ms without frames until an address is forgotten",
         Type::u32,
         static_cast<double>(min_memory.count()),
         static_cast<double>(max_memory.count()),
         {},
         memory_of,
         set_memory,
         memory_text},
        {"gateway/unknown",
         "UNKNOWN",
         "frames to unknown addresses: 0 flood, 1 drop" +
             (names_a_link ? ", 2 to " + of_file.gateway.unknown_link : std::string{}),
         Type::u8,
         0,
         names_a_link ? 2.0 : 1.0,
         {},
         unknown_of,
         set_unknown_choice,
         unknown_text},
    };
    std::set<std::string> taken;
    for (const ManagedParameter& row : rows) taken.insert(row.name);
    for (const LinkSettings& link : of_file.links) {
        const std::string key = "links/" + link.name + "/";
        rows.push_back({key + "enabled", short_name("EN_", link.name, taken), "the link " + link.name + ": 1 enabled, 0 disabled",
                        Type::u8, 0, 1, link.name, enabled_of, set_enabled, enabled_text});
        rows.push_back({key + "limit", short_name("LIM_", link.name, taken),
                        "the link " + link.name + ": maximum frames per second sent of each telemetry message; 0: as configured",
                        Type::f32, 0, max_per_second, link.name, no_limit_of_its_own, set_rate_limit, limit_text_of});
    }
    return rows;
}

double value_in(const Settings& settings, const ManagedParameter& row) {
    const LinkSettings none;
    if (row.link.empty()) return row.get(settings, none);
    const LinkSettings* const link = link_of(settings, row.link);
    return link ? row.get(settings, *link) : 0;
}

std::string_view text(ValueFrom from) noexcept {
    switch (from) {
    case ValueFrom::defaults: return "default";
    case ValueFrom::file: return "file";
    case ValueFrom::parameter: return "parameter";
    }
    return "";
}

void WrittenValues::write(const ManagedParameter& row, double value, const Settings& of_file) {
    const auto words = value_text_in(of_file, row);
    if (!words) return;
    if (value == value_in(of_file, row)) values_.erase(row.key);
    else values_[row.key] = {value, *words};
}

// Checks the range, because a value from a file may be invalid.
std::optional<double> WrittenValues::value(const ManagedParameter& row, const Settings& of_file) const {
    const auto found = values_.find(row.key);
    if (found == values_.end() || value_text_in(of_file, row) != found->second.file) return std::nullopt;
    const double value = found->second.value;
    if (!(value >= row.min && value <= row.max)) return std::nullopt;
    return row.type == Type::f32 ? value : std::floor(value);
}

std::pair<double, ValueFrom> WrittenValues::effective(const ManagedParameter& row, const Settings& of_file) const {
    if (const auto written = value(row, of_file)) return {*written, ValueFrom::parameter};
    const Settings usual;
    const LinkSettings usual_link;
    const bool is_default = *value_text_in(of_file, row) == row.words(usual, usual_link);
    return {value_in(of_file, row), is_default ? ValueFrom::defaults : ValueFrom::file};
}

Settings WrittenValues::applied(Settings of_file) const {
    if (empty() || !is_device(of_file.gateway)) return of_file;
    Settings settings = of_file;
    LinkSettings none;
    for (const ManagedParameter& row : managed_parameters(of_file)) {
        const auto written = value(row, of_file);
        if (!written) continue;
        const auto link = std::find_if(settings.links.begin(), settings.links.end(),
                                       [&](const LinkSettings& of) { return of.name == row.link; });
        row.put(settings, link == settings.links.end() ? none : *link, *written);
    }
    return settings;
}

std::vector<std::string> WrittenValues::forget_stale(const Settings& of_file) {
    std::vector<std::string> forgotten;
    const std::vector<ManagedParameter> rows = managed_parameters(of_file);
    for (auto written = values_.begin(); written != values_.end();) {
        const auto row = std::find_if(rows.begin(), rows.end(),
                                      [&](const ManagedParameter& r) { return r.key == written->first; });
        const bool holds = row != rows.end() && value(*row, of_file);
        if (!holds) forgotten.push_back(written->first);
        written = holds ? std::next(written) : values_.erase(written);
    }
    return forgotten;
}

std::string WrittenValues::text() const {
    Json all = Json::object();
    for (const auto& [key, written] : values_) all[key] = {{"value", written.value}, {"file", written.file}};
    return Json{{"parameters", std::move(all)}}.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::optional<WrittenValues> WrittenValues::parse(std::string_view text) try {
    WrittenValues values;
    const auto all = ano::strict_json<Json>(text);
    if (!all) return std::nullopt;
    for (const auto& [key, written] : all->at("parameters").items())
        values.values_[key] = {written.at("value").get<double>(), written.at("file").get<std::string>()};
    return values;
} catch (const Json::exception&) {
    return std::nullopt;
}

}    // namespace anogate
