#include <ano/values.hpp>
#include <ano/wire.hpp>
#include <host/value.hpp>

#include <array>
#include <charconv>
#include <limits>

namespace ano::host {
namespace {

constexpr Field plain(Type type) noexcept {
    Field field;
    field.type = type;
    return field;
}

template <class T>
std::string whole_range() {
    return std::to_string(std::numeric_limits<T>::min()) + " to " + std::to_string(std::numeric_limits<T>::max());
}

std::string range_of(Type type) {
    switch (type) {
    case Type::u8: return whole_range<std::uint8_t>();
    case Type::i8: return whole_range<std::int8_t>();
    case Type::u16: return whole_range<std::uint16_t>();
    case Type::i16: return whole_range<std::int16_t>();
    case Type::u32: return whole_range<std::uint32_t>();
    case Type::i32: return whole_range<std::int32_t>();
    case Type::u64: return whole_range<std::uint64_t>();
    case Type::i64: return whole_range<std::int64_t>();
    case Type::f32: return "-3.4e38 to 3.4e38";
    default: return "-1.8e308 to 1.8e308";
    }
}

std::optional<Number> number_in(const AnyValue& value) noexcept {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return *i;
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return *u;
    if (const auto* d = std::get_if<double>(&value)) return *d;
    return std::nullopt;
}

}    // namespace

Misfit append(std::vector<std::uint8_t>& out, const AnyValue& value, Type type) {
    if (type == Type::text) {
        const auto* text = std::get_if<std::string>(&value);
        if (text == nullptr) return "is not a text";
        if (text->find('\0') != std::string::npos) return "has a NUL in it";
        out.insert(out.end(), text->begin(), text->end());
        return {};
    }
    const auto number = number_in(value);
    if (!number) return "is not a number";
    std::array<std::uint8_t, 8> wire{};
    switch (store_number(plain(type), *number, wire.data())) {
    case Stored::out_of_range: return "is out of range";
    case Stored::not_whole: return "is not whole";
    case Stored::ok: break;
    }
    out.insert(out.end(), wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(width(type)));
    return {};
}

std::string words_of_misfit(Misfit misfit, Type type) {
    std::string words{misfit};
    if (!misfit.empty() && is_number(type)) words.append(", ").append(name_of(type)).append(" is ").append(range_of(type));
    return words;
}

std::optional<AnyValue> value_of(Bytes bytes, Type type) {
    if (type == Type::text) {
        const std::string_view whole{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
        return std::string{whole.substr(0, whole.find('\0'))};
    }
    if (!is_whole_value(bytes.size(), type)) return std::nullopt;
    const Value value = value_at(plain(type), bytes.data());
    if (const auto* i = std::get_if<std::int64_t>(&value)) return *i;
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return *u;
    return std::get<double>(value);
}

std::string words_of(const AnyValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return '"' + *text + '"';
    std::array<char, 32> digits{};
    const auto written = std::visit(
        [&]<class T>(const T& number) {
            if constexpr (std::is_same_v<T, std::string>) return digits.data();
            else return std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
        },
        value);
    return {digits.data(), written};
}

}    // namespace ano::host
