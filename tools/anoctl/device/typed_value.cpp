#include "typed_value.hpp"

#include <ano/schema.hpp>
#include <ano_json/text.hpp>

#include <host/value.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

std::optional<ano::Type> type_called(std::string_view name) {
    const auto* found = std::find(ano::type_names.begin(), ano::type_names.end(), name);
    if (found == ano::type_names.end()) return std::nullopt;
    return static_cast<ano::Type>(found - ano::type_names.begin());
}

template <class T>
std::string whole_range() {
    return std::to_string(std::numeric_limits<T>::min()) + " to " + std::to_string(std::numeric_limits<T>::max());
}

std::string range_of(ano::Type type) {
    switch (type) {
    case ano::Type::u8: return whole_range<std::uint8_t>();
    case ano::Type::i8: return whole_range<std::int8_t>();
    case ano::Type::u16: return whole_range<std::uint16_t>();
    case ano::Type::i16: return whole_range<std::int16_t>();
    case ano::Type::u32: return whole_range<std::uint32_t>();
    case ano::Type::i32: return whole_range<std::int32_t>();
    case ano::Type::u64: return whole_range<std::uint64_t>();
    case ano::Type::i64: return whole_range<std::int64_t>();
    case ano::Type::f32: return "-3.4e38 to 3.4e38";
    default: return "-1.8e308 to 1.8e308";
    }
}

}    // namespace

std::string misfit_of(const std::string& word, const std::string& type_name) {
    const auto type = type_called(type_name);
    if (!ano::is_utf8(word)) return ano::in_quotes(word) + " is not UTF-8";
    if (!type || !ano::is_number(*type)) return {};
    const auto number = ano::parse_number(word);
    if (!number) return ano::in_quotes(word) + " is no number";
    const auto* const real = std::get_if<double>(&*number);
    if (real != nullptr && !std::isfinite(*real)) return ano::in_quotes(word) + " is no number that can be stored";
    std::vector<std::uint8_t> bytes;
    const auto value = std::visit([](auto plain) { return ano::host::AnyValue{plain}; }, *number);
    const std::string misfit{ano::host::append(bytes, value, *type)};
    if (misfit.empty()) return {};
    return ano::in_quotes(word) + " " + misfit + ", " + type_name + " is " + range_of(*type);
}

}    // namespace anoctl
