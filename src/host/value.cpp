#include <ano/values.hpp>
#include <ano/wire.hpp>
#include <host/value.hpp>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

namespace ano::host {
namespace {

constexpr Field plain(Type type) noexcept {
    Field field;
    field.type = type;
    return field;
}

using Range = std::pair<std::string, std::string>;    // the least and the largest value

template <class T>
Range whole_range() {
    return {std::to_string(std::numeric_limits<T>::min()), std::to_string(std::numeric_limits<T>::max())};
}

Range range_of(Type type) {
    switch (type) {
    case Type::u8: return whole_range<std::uint8_t>();
    case Type::i8: return whole_range<std::int8_t>();
    case Type::u16: return whole_range<std::uint16_t>();
    case Type::i16: return whole_range<std::int16_t>();
    case Type::u32: return whole_range<std::uint32_t>();
    case Type::i32: return whole_range<std::int32_t>();
    case Type::u64: return whole_range<std::uint64_t>();
    case Type::i64: return whole_range<std::int64_t>();
    case Type::f32: return {"-3.4e38", "3.4e38"};
    default: return {"-1.8e308", "1.8e308"};
    }
}

std::optional<Number> number_in(const AnyValue& value) noexcept {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return *i;
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return *u;
    if (const auto* d = std::get_if<double>(&value)) return *d;
    return std::nullopt;
}

// Converting a NaN between f32 and f64 would make it quiet, so its bits are moved here.
constexpr int shorter_by = 52 - 23;    // the difference between the fraction bits of an f64 and an f32
constexpr std::uint64_t f64_exponent = 0x7FF0'0000'0000'0000;
constexpr std::uint32_t f32_exponent = 0x7F80'0000, f32_fraction = 0x007F'FFFF, f32_quiet = 0x0040'0000, f32_sign = 0x8000'0000;

double wide_nan(std::uint32_t bits) noexcept {
    return std::bit_cast<double>(std::uint64_t{bits & f32_sign} << 32 | f64_exponent |
                                 std::uint64_t{bits & f32_fraction} << shorter_by);
}

std::uint32_t narrow_nan(double nan) noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(nan);
    const auto fraction = static_cast<std::uint32_t>(bits >> shorter_by) & f32_fraction;
    return (static_cast<std::uint32_t>(bits >> 32) & f32_sign) | f32_exponent | (fraction != 0 ? fraction : f32_quiet);
}

}    // namespace

Misfit append(std::vector<std::uint8_t>& out, const AnyValue& value, Type type) {
    if (type == Type::text) {
        const auto* text = std::get_if<std::string>(&value);
        if (text == nullptr) return {"not_a_text"};
        if (text->find('\0') != std::string::npos) return {"has_a_nul"};
        out.insert(out.end(), text->begin(), text->end());
        return {};
    }
    const auto number = number_in(value);
    if (!number) return {"not_a_number"};
    std::array<std::uint8_t, 8> wire{};
    const auto* const real = std::get_if<double>(&*number);
    if (type == Type::f32 && real != nullptr && std::isnan(*real)) store(wire.data(), narrow_nan(*real));
    else switch (store_number(plain(type), *number, wire.data())) {
        case Stored::out_of_range: return {"out_of_range"};
        case Stored::not_whole: return {"not_whole"};
        case Stored::ok: break;
        }
    out.insert(out.end(), wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(width(type)));
    return {};
}

Misfit with_range(const Misfit& misfit, Type type) {
    if (misfit.empty() || !is_number(type)) return misfit;
    const auto [min, max] = range_of(type);
    return {"out_of_type", misfit, name_of(type), min, max};
}

std::optional<AnyValue> value_of(Bytes bytes, Type type) {
    if (type == Type::text) {
        const std::string_view whole{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
        return std::string{whole.substr(0, whole.find('\0'))};
    }
    if (!is_whole_value(bytes.size(), type)) return std::nullopt;
    if (const auto bits = type == Type::f32 ? load<std::uint32_t>(bytes.data()) : 0; std::isnan(std::bit_cast<float>(bits)))
        return wide_nan(bits);
    const Value value = value_at(plain(type), bytes.data());
    if (const auto* i = std::get_if<std::int64_t>(&value)) return *i;
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return *u;
    return std::get<double>(value);
}

bool same_bytes(const AnyValue& a, const AnyValue& b, Type type) {
    std::vector<std::uint8_t> of_a, of_b;
    return append(of_a, a, type).empty() && append(of_b, b, type).empty() && of_a == of_b;
}

std::string to_string(const AnyValue& value) {
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
