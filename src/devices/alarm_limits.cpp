#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <devices/alarm_limits.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view limit_keys[] = {"field", "side", "amber", "red", "cells", "for_s"};
constexpr std::size_t max_field = 80;
constexpr unsigned max_cells = 32;
constexpr double max_for_s = 60;

bool is_field(std::string_view word) {
    const auto is_part = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-';
    };
    const auto point = word.find('.');
    return word.size() <= max_field && point != 0 && point != word.npos && point + 1 < word.size() &&
           std::all_of(word.begin(), word.end(), is_part);
}

/// std::nullopt in `into`: the key is missing. False: the value is not a finite number.
bool read_number(const Json& json, const char* key, std::optional<double>& into) {
    if (!json.contains(key)) return true;
    if (!json[key].is_number() || !std::isfinite(json[key].get<double>())) return false;
    into = json[key].get<double>();
    return true;
}

std::variant<AlarmLimit, std::string> limit_in(const Json& json) {
    if (!json.is_object()) return std::string{"must be an object"};
    for (const auto& [key, value] : json.items())
        if (std::find(std::begin(limit_keys), std::end(limit_keys), key) == std::end(limit_keys))
            return "unknown key " + ano::in_quotes(key) + ano::did_you_mean(key, limit_keys);
    AlarmLimit limit;
    if (!json.contains("field") || !json["field"].is_string() || !is_field(json["field"].get<std::string>()))
        return std::string{"'field' must be a message and its field, such as 'power.voltage'"};
    limit.field = json["field"].get<std::string>();
    const Json side = json.value("side", Json{});
    if (side != "below" && side != "above") return std::string{"'side' must be 'below' or 'above'"};
    limit.is_below = side == "below";
    if (!read_number(json, "amber", limit.amber) || !read_number(json, "red", limit.red))
        return std::string{"'amber' and 'red' must be numbers"};
    if (!limit.amber && !limit.red) return std::string{"'amber' or 'red' is needed"};
    if (limit.amber && limit.red && (limit.is_below ? *limit.red > *limit.amber : *limit.red < *limit.amber))
        return std::string{"'red' must be beyond 'amber'"};
    if (json.contains("cells")) {
        if (!json["cells"].is_number_unsigned() || json["cells"] < 1u || json["cells"] > max_cells)
            return std::string{"'cells' must be a number from 1 to 32"};
        limit.cells = json["cells"].get<unsigned>();
    }
    std::optional<double> for_s;
    if (!read_number(json, "for_s", for_s) || for_s.value_or(0) < 0 || for_s.value_or(0) > max_for_s)
        return std::string{"'for_s' must be seconds from 0 to 60"};
    limit.for_s = for_s.value_or(0);
    return limit;
}

// "power.voltage", …: the fields in frames of `source` that can have a limit.
std::vector<std::string> all_fields(std::uint8_t source, const ano::FlexibleLayouts& layouts) {
    std::vector<std::string> all;
    const auto add = [&](std::string_view message, std::span<const ano::Field> fields) {
        for (const ano::Field& field : fields)
            if (ano::is_number(field.type) && field.count == 1)
                all.push_back(std::string{message} + "." + std::string{field.name});
    };
    for (const ano::Message& message : ano::messages) {
        add(message.name, message.fields());
        if (!message.is_base()) continue;
        for (const ano::FlexibleLayout* layout : layouts.layouts_for(message.id, source)) add(message.name, layout->fields());
    }
    return all;
}

}    // namespace

std::string AlarmLimits::unknown_field(const List& list, std::uint8_t source, const ano::FlexibleLayouts& layouts) {
    const std::vector<std::string> all = all_fields(source, layouts);
    for (const AlarmLimit& limit : list) {
        if (std::find(all.begin(), all.end(), limit.field) != all.end()) continue;
        const std::string begin = limit.field.substr(0, limit.field.find('.') + 1);
        std::vector<std::string_view> candidates;
        std::string of_message;
        for (const std::string& field : all) {
            if (!field.starts_with(begin)) continue;
            if (std::find(candidates.begin(), candidates.end(), field) == candidates.end())
                of_message.append(of_message.empty() ? "; there are " : ", ").append(field);
            candidates.emplace_back(field);
        }
        if (candidates.empty()) candidates.assign(all.begin(), all.end());
        const std::string meant = ano::did_you_mean(limit.field, candidates);
        if (of_message.empty() && meant.empty()) of_message = "; GET /messages lists the messages and their fields";
        return "no message has the numeric field " + ano::in_quotes(limit.field) + meant + of_message;
    }
    return {};
}

std::variant<AlarmLimits::List, std::string> AlarmLimits::parse(const Json& json) {
    if (!json.is_object() || json.size() != 1 || !json.contains("limits") || !json["limits"].is_array())
        return std::string{R"(the body must be {"limits": [...]})"};
    const Json& rows = json["limits"];
    if (rows.size() > max_limits) return "there are " + std::to_string(rows.size()) + " limits; at most 32 are kept";
    List list;
    for (const Json& row : rows) {
        auto limit = limit_in(row);
        if (const auto* wrong = std::get_if<std::string>(&limit))
            return "limit " + std::to_string(list.size() + 1) + ": " + *wrong;
        auto& one = std::get<AlarmLimit>(limit);
        const auto is_same = [&](const AlarmLimit& other) { return other.field == one.field && other.is_below == one.is_below; };
        if (std::any_of(list.begin(), list.end(), is_same))
            return one.field + " has two limits " + (one.is_below ? "below" : "above") + " it";
        list.push_back(std::move(one));
    }
    return list;
}

Json AlarmLimits::json(const List& list) {
    Json rows = Json::array();
    for (const AlarmLimit& limit : list) {
        Json row{{"field", limit.field}, {"side", limit.is_below ? "below" : "above"}};
        if (limit.amber) row["amber"] = *limit.amber;
        if (limit.red) row["red"] = *limit.red;
        if (limit.cells) row["cells"] = *limit.cells;
        if (limit.for_s > 0) row["for_s"] = limit.for_s;
        rows.push_back(std::move(row));
    }
    return {{"limits", std::move(rows)}};
}

// FNV-1a of the text.
std::uint32_t AlarmLimits::version(std::uint8_t address) const {
    if (lists_[address].empty()) return 0;
    std::uint32_t hash = 0x811C9DC5;
    for (const char c : json(lists_[address]).dump()) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x01000193;
    return hash == 0 ? 1 : hash;
}

std::string limits_file(std::uint8_t address) { return "limits-" + ano::hex_byte(address) + ".json"; }

std::optional<std::uint8_t> address_of_limits_file(std::string_view name) {
    if (!name.starts_with("limits-0x")) return std::nullopt;
    for (unsigned a = 1; a < 255; ++a)
        if (name == limits_file(static_cast<std::uint8_t>(a))) return static_cast<std::uint8_t>(a);
    return std::nullopt;
}

}    // namespace anogate
