#include <ros2/type_hash.hpp>

#include <openssl/evp.h>

#include <array>
#include <map>

namespace anogate {
namespace {

constexpr unsigned sequence = 144, array = 48;    // added to the number of the type

// FIELD_TYPE_… of type_description_interfaces/FieldType
unsigned number_of(RosType type) noexcept {
    switch (type) {
    case RosType::message: return 1;
    case RosType::int8: return 2;
    case RosType::uint8: return 3;
    case RosType::int16: return 4;
    case RosType::uint16: return 5;
    case RosType::int32: return 6;
    case RosType::uint32: return 7;
    case RosType::int64: return 8;
    case RosType::uint64: return 9;
    case RosType::float32: return 10;
    case RosType::float64: return 11;
    case RosType::boolean: return 15;
    case RosType::byte: return 16;
    case RosType::text: return 17;
    }
    return 0;
}

std::string field_text(std::string_view name, unsigned type, std::size_t capacity, const RosMessage* nested) {
    return R"({"name": ")" + std::string{name} + R"(", "type": {"type_id": )" + std::to_string(type) + R"(, "capacity": )" +
           std::to_string(capacity) + R"(, "string_capacity": 0, "nested_type_name": ")" +
           (nested != nullptr ? full_name(*nested) : std::string{}) + R"("}})";
}

std::string field_text(const RosField& field) {
    const bool is_array = field.shape == RosField::Shape::array;
    const unsigned shape = is_array ? array : field.shape == RosField::Shape::sequence ? sequence : 0;
    return field_text(field.name, number_of(field.type) + shape, is_array ? field.count : 0, field.message);
}

std::string description(const RosMessage& message) {
    std::string fields;
    for (const RosField& field : message.fields) fields += (fields.empty() ? "" : ", ") + field_text(field);
    if (message.fields.empty()) fields = field_text("structure_needs_at_least_one_member", number_of(RosType::uint8), 0, nullptr);
    return R"({"type_name": ")" + full_name(message) + R"(", "fields": [)" + fields + "]}";
}

void collect(const RosMessage& message, std::map<std::string, std::string>& descriptions) {
    for (const RosField& field : message.fields)
        if (field.message != nullptr && descriptions.emplace(full_name(*field.message), description(*field.message)).second)
            collect(*field.message, descriptions);
}

}    // namespace

std::string type_hash(const RosMessage& message) {
    std::map<std::string, std::string> referenced;    // sorted by name, as the hash requires
    collect(message, referenced);
    std::string all;
    for (const auto& [name, text] : referenced) all += (all.empty() ? "" : ", ") + text;
    const std::string text = R"({"type_description": )" + description(message) + R"(, "referenced_type_descriptions": [)" + all +
                             "]}";
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) return {};
    std::string hash = "RIHS01_";
    for (unsigned i = 0; i < size; ++i) {
        constexpr std::string_view digits = "0123456789abcdef";
        hash += digits[digest[i] >> 4];
        hash += digits[digest[i] & 15];
    }
    return hash;
}

std::string dds_type_name(const RosMessage& message) { return message.package + "::msg::dds_::" + message.name + '_'; }

}    // namespace anogate
