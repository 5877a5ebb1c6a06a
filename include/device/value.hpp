// Values of parameters and commands, of all types that the protocol has for them (protocol text, section 4, 0xC2 and 0xE2).
#pragma once
#include <ano/reading.hpp>
#include <ano/schema.hpp>

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace ano::device {

/// i8 to i64 and u8 to u32 as std::int64_t, u64 as std::uint64_t, f32 and f64 as double, text as std::string.
using Value = std::variant<std::int64_t, std::uint64_t, double, std::string>;

namespace detail {
template <class T>
constexpr std::optional<Type> type_for() {
    if constexpr (std::is_same_v<T, std::string>) return Type::text;
    else if constexpr (std::is_same_v<T, float>) return Type::f32;
    else if constexpr (std::is_same_v<T, double>) return Type::f64;
    else if constexpr (std::integral<T> && !std::is_same_v<T, bool>) {
        constexpr bool has_sign = std::is_signed_v<T>;
        switch (sizeof(T)) {
        case 1: return has_sign ? Type::i8 : Type::u8;
        case 2: return has_sign ? Type::i16 : Type::u16;
        case 4: return has_sign ? Type::i32 : Type::u32;
        case 8: return has_sign ? Type::i64 : Type::u64;
        default: break;
        }
    }
    return std::nullopt;
}
}    // namespace detail

/// A C++ type that the protocol has as well: an integer of 1 to 8 bytes, float, double, std::string.
template <class T>
concept Wire = detail::type_for<T>()
.has_value();
template <class T>
concept WireNumber = Wire<T> && !std::is_same_v<T, std::string>;

template <Wire T>
inline constexpr Type type_of = *detail::type_for<T>();

template <Wire T>
Value to_value(const T& value) {
    if constexpr (std::is_same_v<T, std::string>) return value;
    else if constexpr (std::is_floating_point_v<T>) return static_cast<double>(value);
    else if constexpr (type_of<T> == Type::u64) return static_cast<std::uint64_t>(value);
    else return static_cast<std::int64_t>(value);
}

/// `value` converted to T, the type from which it was made or a type with the same alternative.
template <Wire T>
T from_value(const Value& value) {
    if constexpr (std::is_same_v<T, std::string>) {
        const auto* text = std::get_if<std::string>(&value);
        return text == nullptr ? T{} : *text;
    } else {
        return std::visit(
            []<class V>(const V& v) -> T {
                if constexpr (std::is_same_v<V, std::string>) return T{};
                else return static_cast<T>(v);
            },
            value);
    }
}

/// Whether `type` can represent `value`: it has the right alternative, and a number is within the range of the wire type.
bool fits(const Value& value, Type type) noexcept;
/// The smallest and the largest value of `type`, which must be a number.
std::pair<Value, Value> range_of(Type type);
/// Whether `value` is NaN, which can't be compared with a limit.
bool is_nan(const Value& value) noexcept;
/// 0, or empty.
Value zero_of(Type type);

/// The value at the beginning of `bytes`. For a number these are at least width(type) bytes. Text ends at its first NUL or at the
/// end of `bytes`.
Value read_value(Type type, Bytes bytes);
/// Appends the value to `out` in its wire format. An empty text is one NUL: a value has at least one byte.
void append_value(std::vector<std::uint8_t>& out, Type type, const Value& value);

/// The value times `factor` as i32, for older devices that send every number as i32: clamped to its range, fractions rounded.
/// Text is 0.
std::int32_t as_i32(const Value& value, std::int32_t factor = 1) noexcept;
/// The number of `type` nearest to `number` / `factor`.
Value from_i32(Type type, std::int32_t number, std::int32_t factor = 1);

}    // namespace ano::device
