#include <ano/hex.hpp>
#include <ano_json/text.hpp>
#include <devices/device_json.hpp>

#include <nlohmann/json.hpp>

#include <cmath>
#include <type_traits>
#include <utility>
#include <variant>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::host::AnyValue;

double tenths(double value) { return std::round(value * 10) / 10; }

}    // namespace

Json identity_json(std::uint8_t address, const std::optional<ano::host::DeviceInfo>& info, const DeviceTexts& texts) {
    Json json{{"address", ano::hex_byte(address)}};
    if (!info) return json;
    json["name"] = texts.display_text(info->name);
    json["dev_id"] = info->dev_id;
    json["hw"] = info->hw_ver;
    json["sw"] = info->sw_ver;
    json["bl"] = info->bl_ver;
    json["pt"] = info->pt_ver;
    return json;
}

std::optional<ano::host::DeviceInfo> identity_in(const Json& json) {
    if (!json.is_object() || !json.contains("name") || !json["name"].is_string()) return std::nullopt;
    const auto number = [&](const char* key) {
        const Json value = json.value(key, Json{});
        return value.is_number_unsigned() ? value.get<std::uint16_t>() : std::uint16_t{0};
    };
    return ano::host::DeviceInfo{static_cast<std::uint8_t>(number("dev_id")),
                                 number("hw"),
                                 number("sw"),
                                 number("bl"),
                                 number("pt"),
                                 json["name"].get<std::string>()};
}

Json device_json(const DeviceReport& report, ano::TimePoint now) {
    Json json = identity_json(report.heard.address, report.info, report.texts);
    if (report.texts.encoding() == ano::Encoding::gbk) json["encoding"] = "gbk";
    if (report.texts.contradicts()) json["hint"] = encoding_hint;
    if (!report.heard.link.empty()) json["link"] = report.heard.link;
    if (!report.heard.peer.empty()) json["peer"] = report.heard.peer;
    if (report.heard.heard_at) json["age"] = tenths(std::chrono::duration<double>(now - *report.heard.heard_at).count());
    if (report.rate) json["rate"] = tenths(*report.rate);
    if (report.parameters) json["parameters"] = *report.parameters;
    if (report.job) json["job"] = *report.job;
    if (report.limits != 0) json["limits"] = report.limits;
    if (report.red_lines > 0) json["red_lines"] = report.red_lines;
    for (const std::string& note : report.notes) {
        if (is_loader_note(note)) json["in_loader"] = true;
        else json[is_note(note) ? "kept" : "dropped"].push_back(note);
    }
    return json;
}

Json value_json(const AnyValue& value, std::optional<ano::Type> type, const DeviceTexts& texts) {
    if (const auto* text = std::get_if<std::string>(&value)) return texts.display_text(*text);
    if (const auto* number = std::get_if<double>(&value)) {
        if (std::isnan(*number)) return "nan";    // JSON has no such numbers
        if (std::isinf(*number)) return *number > 0 ? "inf" : "-inf";
        return type == ano::Type::f32 ? ano::widened(static_cast<float>(*number)) : *number;
    }
    return std::visit([](const auto& plain) { return Json(plain); }, value);
}

std::optional<AnyValue> value_in(const Json& json, std::optional<ano::Type> type) {
    if (json.is_number_unsigned()) return AnyValue{json.get<std::uint64_t>()};
    if (json.is_number_integer()) return AnyValue{json.get<std::int64_t>()};
    if (json.is_number_float()) return AnyValue{json.get<double>()};
    if (!json.is_string()) return std::nullopt;
    auto text = json.get<std::string>();
    if (!type || *type == ano::Type::text) return AnyValue{std::move(text)};
    const auto number = ano::parse_number(text);
    const auto* const real = number ? std::get_if<double>(&*number) : nullptr;
    if (!number || (real != nullptr && !std::isfinite(*real)))
        return AnyValue{std::move(text)};    // the caller, which knows the type, reports the error
    return std::visit([](auto plain) { return AnyValue{plain}; }, *number);
}

std::string_view to_string(ano::ValueType7 seven) noexcept { return seven == ano::ValueType7::u64 ? "u64" : "f32"; }

std::optional<ano::ValueType7> value_type_7_in(const Json& json) {
    if (json == "f32") return ano::ValueType7::f32;
    if (json == "u64") return ano::ValueType7::u64;
    return std::nullopt;
}

Json parameter_json(const ano::host::ParameterInfo& info, const std::optional<AnyValue>& value, bool with_value,
                    const DeviceTexts& texts) {
    Json json{{"id", info.id}};
    const bool came = !info.name.empty() || info.type;
    if (came) {
        json["name"] = texts.display_text(info.name);
        json["type"] = info.type ? Json(name_of(*info.type)) : Json(nullptr);
    }
    if (value) json["value"] = value_json(*value, info.type, texts);
    if (info.limits) {
        json["min"] = info.limits->min;
        json["max"] = info.limits->max;
    }
    if (info.is_scaled()) json["mul"] = info.mul;
    if (!info.info.empty()) json["text"] = texts.display_text(info.info);
    if (info.limits) json["older"] = true;
    if (!came || (with_value && !value)) json["missing"] = true;
    return json;
}

}    // namespace anogate
