#include <ano/wire.hpp>
#include <ano_json/compact_json.hpp>
#include <ano_json/frame_json.hpp>
#include <ros/ros_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace anogate {
namespace {

using ano::Json;
using RosShape = RosField::Shape;

std::string base64_of(ano::Bytes bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
        std::uint32_t group = 0;
        for (std::size_t i = 0; i < 3; ++i) group = group << 8 | (i < count ? bytes[at + i] : 0u);
        for (std::size_t i = 0; i < 4; ++i) text += i <= count ? digits[group >> (18 - 6 * i) & 63] : '=';
    }
    return text;
}

Json number_json(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

Json value_json(RosType type, const ano::Value& value) {
    if (type == RosType::text) {
        const auto* const text = std::get_if<std::string_view>(&value);
        return text != nullptr ? std::string{*text} : std::string{};
    }
    std::int64_t whole = 0;
    if (const auto* const real = std::get_if<double>(&value)) return number_json(*real);
    if (const auto* const number = std::get_if<std::uint64_t>(&value)) {
        if (type != RosType::boolean) return *number;
        whole = *number != 0;
    } else if (const auto* const signed_number = std::get_if<std::int64_t>(&value)) {
        whole = *signed_number;
    } else {
        return nullptr;
    }
    return type == RosType::boolean ? Json(whole != 0) : Json(whole);
}

// Reads the values field by field.
class RosJson {
public:
    explicit RosJson(std::span<const ano::Value> values) : values_{values} {}

    Json message(const RosMessage& message) {
        Json object = Json::object();
        for (const RosField& field : message.fields) {
            Json value = field_json(field);
            if (!value.is_null()) object[field.name] = std::move(value);
        }
        return object;
    }

private:
    const ano::Value& next() noexcept {
        static const ano::Value nothing{};
        if (values_.empty()) return nothing;
        const ano::Value& value = values_.front();
        values_ = values_.subspan(1);
        return value;
    }
    Json one(const RosField& field) {
        return field.type == RosType::message ? message(*field.message) : value_json(field.type, next());
    }
    Json field_json(const RosField& field) {
        if (field.shape == RosShape::one) return one(field);
        if (field.type == RosType::uint8) {
            const auto* const bytes = std::get_if<ano::Bytes>(&next());
            return base64_of(bytes != nullptr ? *bytes : ano::Bytes{});
        }
        if (field.shape == RosShape::array && !values_.empty() && std::holds_alternative<ano::Bytes>(values_.front()))
            return array_of(std::get<ano::Bytes>(next()), field.count);
        std::size_t count = field.count;
        if (field.shape == RosShape::sequence) {
            const auto* const told = std::get_if<std::uint64_t>(&next());
            count = std::min<std::size_t>(told != nullptr ? *told : 0, values_.size());
        }
        Json array = Json::array();
        for (std::size_t i = 0; i < count; ++i) array.push_back(one(field));
        return array;
    }
    // Of float64 only: no message has other numbers as bytes.
    static Json array_of(ano::Bytes bytes, std::size_t count) {
        Json array = Json::array();
        for (std::size_t i = 0; i < count && (i + 1) * sizeof(double) <= bytes.size(); ++i)
            array.push_back(number_json(ano::load<double>(bytes.data() + i * sizeof(double))));
        return array;
    }

    std::span<const ano::Value> values_;
};

Json ros_schema(const RosMessage& message);

Json type_schema(const RosField& field) {
    switch (field.type) {
    case RosType::boolean: return {{"type", "boolean"}};
    case RosType::text: return {{"type", "string"}};
    case RosType::message: return ros_schema(*field.message);
    case RosType::float32:
    case RosType::float64: return {{"type", "number"}};
    default: return {{"type", "integer"}};
    }
}

Json field_schema(const RosField& field) {
    if (field.shape == RosShape::one) return type_schema(field);
    if (field.type == RosType::uint8) return {{"type", "string"}, {"contentEncoding", "base64"}};
    return {{"type", "array"}, {"items", type_schema(field)}};
}

std::string description_of(const RosField& field) {
    std::string text = field.comment;
    for (const RosConstant& constant : field.constants)
        text += (text.empty() ? "" : "; ") + std::to_string(constant.value) + ": " + constant.name;
    return text;
}

Json ros_schema(const RosMessage& message) {
    Json schema{{"title", full_name(message)}, {"type", "object"}, {"properties", Json::object()}};
    for (const RosField& field : message.fields) {
        Json& property = schema["properties"][field.name] = field_schema(field);
        if (const std::string text = description_of(field); !text.empty()) property["description"] = text;
    }
    return schema;
}

}    // namespace

std::string ros_json(const RosMessage& message, std::span<const ano::Value> values) {
    return ano::compact_json(RosJson{values}.message(message));
}

std::string ros_json_schema(const RosMessage& message) { return ano::compact_json(ros_schema(message)); }

}    // namespace anogate
