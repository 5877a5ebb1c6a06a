#include <ano/values.hpp>
#include <ano/wire.hpp>
#include <host/value.hpp>

#include <array>
#include <charconv>

namespace ano::host {
namespace {

constexpr Field plain(Type type) noexcept {
    Field field;
    field.type = type;
    return field;
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
