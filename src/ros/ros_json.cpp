#include <ano/wire.hpp>
#include <ano_json/compact_json.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/json_writer.hpp>
#include <ros/ros_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace anogate {
namespace {

using ano::Json;
using RosShape = RosField::Shape;

std::string base64_of(ano::Bytes bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text((bytes.size() + 2) / 3 * 4, '=');
    auto to = text.begin();
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
        std::uint32_t group = 0;
        for (std::size_t i = 0; i < 3; ++i) group = group << 8 | (i < count ? bytes[at + i] : 0u);
        for (std::size_t i = 0; i < 4; ++i, ++to)
            if (i <= count) *to = digits[group >> (18 - 6 * i) & 63];
    }
    return text;
}

// Consumes the values field by field.
class RosJson {
public:
    RosJson(std::span<const ano::Value> values, std::string& out) : values_{values}, out_{out} {}

    void write(const RosMessage& message) {
        out_.begin_object();
        for (const RosField& field : message.fields) out_.member_unless_null(field.name, [&] { write_field(field); });
        out_.end_object();
    }

private:
    const ano::Value& next() noexcept {
        static const ano::Value nothing{};
        if (values_.empty()) return nothing;
        const ano::Value& value = values_.front();
        values_ = values_.subspan(1);
        return value;
    }
    void write_one(const RosField& field) {
        if (field.type == RosType::message) return write(*field.message);
        const ano::Value& value = next();
        if (field.type == RosType::text) {
            const auto* const text = std::get_if<std::string_view>(&value);
            return out_.text(text != nullptr ? *text : std::string_view{});
        }
        if (const auto* const real = std::get_if<double>(&value)) return out_.number(*real);
        const auto write_whole = [&](auto whole) {
            field.type == RosType::boolean ? out_.boolean(whole != 0) : out_.number(whole);
        };
        if (const auto* const whole = std::get_if<std::uint64_t>(&value)) return write_whole(*whole);
        if (const auto* const whole = std::get_if<std::int64_t>(&value)) return write_whole(*whole);
        out_.null();
    }
    void write_field(const RosField& field) {
        if (field.shape == RosShape::one) return write_one(field);
        if (field.type == RosType::uint8) {
            const auto* const bytes = std::get_if<ano::Bytes>(&next());
            return out_.text(base64_of(bytes != nullptr ? *bytes : ano::Bytes{}));
        }
        std::size_t count = field.count;
        out_.begin_array();
        if (field.shape == RosShape::array && !values_.empty() && std::holds_alternative<ano::Bytes>(values_.front())) {
            // Only numbers of type float64 are passed as bytes.
            const ano::Bytes bytes = std::get<ano::Bytes>(next());
            for (std::size_t i = 0; i < std::min(count, bytes.size() / sizeof(double)); ++i)
                out_.number(ano::load<double>(bytes.data() + i * sizeof(double)));
        } else {
            if (field.shape == RosShape::sequence) {
                const auto* const declared = std::get_if<std::uint64_t>(&next());
                count = std::min<std::size_t>(declared != nullptr ? *declared : 0, values_.size());
            }
            for (std::size_t i = 0; i < count; ++i) write_one(field);
        }
        out_.end_array();
    }

    std::span<const ano::Value> values_;
    ano::JsonWriter out_;
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

void write_ros_json(const RosMessage& message, std::span<const ano::Value> values, std::string& out) {
    RosJson{values, out}.write(message);
}

std::string ros_json_schema(const RosMessage& message) { return ano::compact_json(ros_schema(message)); }

}    // namespace anogate
