#include <mavlink/parameter_table.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_set>

namespace anogate::mavlink {
namespace {

constexpr std::size_t max_name = 16, kept_of_name = 11;

// 4 digits of the FNV-1a hash.
std::string name_digits(std::string_view name, std::uint32_t attempt) {
    std::uint32_t hash = 2'166'136'261u + attempt;
    for (const char c : name) hash = (hash ^ static_cast<std::uint8_t>(c)) * 16'777'619u;
    std::string digits;
    for (unsigned i = 0; i < 4; ++i) digits += "0123456789ABCDEF"[hash >> (4 * i) & 0xFu];
    return digits;
}

std::uint8_t type_number(ano::Type type) noexcept {
    switch (type) {
    case ano::Type::u8: return 1;
    case ano::Type::i8: return 2;
    case ano::Type::u16: return 3;
    case ano::Type::i16: return 4;
    case ano::Type::u32: return 5;
    case ano::Type::i32: return 6;
    case ano::Type::f32: return 9;
    default: return 0;
    }
}

ano::Field field_of(ano::Type type) noexcept {
    ano::Field field;
    field.type = type;
    return field;
}

}    // namespace

std::vector<std::string> short_names(std::span<const std::string> names) {
    std::unordered_set<std::string> used;
    for (const std::string& name : names)
        if (name.size() <= max_name) used.insert(name);
    std::vector<std::string> all;
    for (const std::string& name : names) {
        std::string id = name;
        for (std::uint32_t attempt = 0; id.size() > max_name || (id != name && !used.insert(id).second); ++attempt)
            id = name.substr(0, kept_of_name) + '~' + name_digits(name, attempt);
        if (id != name) used.insert(id);
        all.push_back(std::move(id));
    }
    return all;
}

std::optional<float> bytewise(ano::Type type, const ano::Number& value) noexcept {
    std::array<std::uint8_t, 8> bytes{};
    if (type_number(type) == 0 || ano::store_number(field_of(type), value, bytes.data()) != ano::Stored::ok) return std::nullopt;
    return ano::load<float>(bytes.data());
}

std::optional<ano::Number> value_of(ano::Type type, float value) noexcept {
    if (type_number(type) == 0) return std::nullopt;
    std::array<std::uint8_t, 4> bytes{};
    ano::store(bytes.data(), std::bit_cast<std::uint32_t>(value));
    return ano::with_type(type, [&]<class T>(T) -> std::optional<ano::Number> {
        if constexpr (sizeof(T) > sizeof(float)) return std::nullopt;
        else if constexpr (std::is_floating_point_v<T>) return ano::Number{static_cast<double>(ano::load<T>(bytes.data()))};
        else return ano::Number{static_cast<std::int64_t>(ano::load<T>(bytes.data()))};
    });
}

ParameterTable::ParameterTable(std::span<const DeviceParameter> parameters) {
    std::vector<std::string> names;
    for (const DeviceParameter& parameter : parameters) {
        const auto value = parameter.value ? bytewise(parameter.type, *parameter.value) : std::nullopt;
        if (!value) {
            left_out_.push_back(parameter.name);
            continue;
        }
        names.push_back(parameter.name);
        rows_.push_back({"", parameter.name, parameter.type, type_number(parameter.type), *value});
    }
    const auto ids = short_names(names);
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].id = ids[i];
}

std::optional<std::size_t> ParameterTable::find(std::string_view id) const noexcept {
    const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.id == id; });
    return found == rows_.end() ? std::nullopt : std::optional{static_cast<std::size_t>(found - rows_.begin())};
}

}    // namespace anogate::mavlink
