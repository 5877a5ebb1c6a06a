// Numbers in the format of the wire: packed, scaled, little-endian unless their field specifies otherwise.
#pragma once
#include <ano/schema.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

namespace ano {

/// The T at `at`; sizeof(T) bytes must be readable.
template <class T>
constexpr T load(const std::uint8_t* at) noexcept {
    if (std::endian::native == std::endian::little && !std::is_constant_evaluated()) {
        T value;
        std::memcpy(&value, at, sizeof value);
        return value;
    }
    using Bits = std::conditional_t<
        sizeof(T) == 1, std::uint8_t,
        std::conditional_t<sizeof(T) == 2, std::uint16_t, std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) bits |= std::uint64_t{at[i]} << (8 * i);
    return std::bit_cast<T>(static_cast<Bits>(bits));
}

template <class T>
constexpr void store(std::uint8_t* at, T value) noexcept {
    using Bits = std::conditional_t<
        sizeof(T) == 1, std::uint8_t,
        std::conditional_t<sizeof(T) == 2, std::uint16_t, std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;
    const std::uint64_t bits = std::bit_cast<Bits>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) at[i] = static_cast<std::uint8_t>(bits >> (8 * i));
}

/// The same in the byte order of a field.
template <class T>
constexpr T load(const std::uint8_t* at, ByteOrder order) noexcept {
    if (order == ByteOrder::little) return load<T>(at);
    std::uint8_t bytes[sizeof(T)]{};
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = at[sizeof(T) - 1 - i];
    return load<T>(bytes);
}

template <class T>
constexpr void store(std::uint8_t* at, T value, ByteOrder order) noexcept {
    store(at, value);
    if (order == ByteOrder::big) std::reverse(at, at + sizeof(T));
}

/// Calls `f` with a T{} of the C++ type for `type`; with std::uint8_t{} for types that are not numbers.
template <class F>
constexpr decltype(auto) with_type(Type type, F&& f) {
    switch (type) {
    case Type::i8: return f(std::int8_t{});
    case Type::u16: return f(std::uint16_t{});
    case Type::i16: return f(std::int16_t{});
    case Type::u32: return f(std::uint32_t{});
    case Type::i32: return f(std::int32_t{});
    case Type::u64: return f(std::uint64_t{});
    case Type::i64: return f(std::int64_t{});
    case Type::f32: return f(float{});
    case Type::f64: return f(double{});
    default: return f(std::uint8_t{});
    }
}

/// A number for a field, in its unit.
using Number = std::variant<std::int64_t, std::uint64_t, double>;

enum class Stored : std::uint8_t {
    ok,
    out_of_range,    // the wire type can't represent it
    not_whole,       // a fraction for an integer without scale
};

/// Smallest and largest value that the wire type of `field` can represent, in its unit.
inline std::pair<double, double> limits_of(const Field& field) noexcept {
    return with_type(field.type, [&]<class T>(T) {
        const double k = field.scale.value / field.scale.wire;
        return std::pair{static_cast<double>(std::numeric_limits<T>::lowest()) * k,
                         static_cast<double>(std::numeric_limits<T>::max()) * k};
    });
}

namespace detail {

template <class T>
Stored store_double(std::uint8_t* at, double value, Scale scale, ByteOrder order) noexcept {
    if constexpr (std::is_floating_point_v<T>) {
        const double wire = value * scale.wire / scale.value;
        const T narrow = static_cast<T>(wire);
        if (std::isfinite(value) && !std::isfinite(narrow)) return Stored::out_of_range;
        store(at, narrow, order);
    } else {
        if (scale.is_one() && std::isfinite(value) && value != std::trunc(value)) return Stored::not_whole;
        const double wire = std::round(value * scale.wire / scale.value);
        // 2^n has an exact double; the maximum of T may not.
        const double end = std::ldexp(1.0, std::numeric_limits<T>::digits);
        const double first = std::is_signed_v<T> ? -end : 0.0;
        if (!(wire >= first && wire < end)) return Stored::out_of_range;
        store(at, static_cast<T>(wire), order);
    }
    return Stored::ok;
}

}    // namespace detail

/// Writes `number` at `at`, scaled and rounded to the nearest step. Writes nothing if the wire type can't represent it. Only for
/// fields that are numbers.
inline Stored store_number(const Field& field, const Number& number, std::uint8_t* at) noexcept {
    return with_type(field.type, [&]<class T>(T) {
        return std::visit(
            [&]<class N>(N n) {
                if constexpr (std::is_integral_v<T> && std::is_integral_v<N>) {
                    if (field.scale.is_one()) {
                        if (!std::in_range<T>(n)) return Stored::out_of_range;
                        store(at, static_cast<T>(n), field.order);
                        return Stored::ok;
                    }
                }
                return detail::store_double<T>(at, static_cast<double>(n), field.scale, field.order);
            },
            number);
    });
}

/// Writes the wire value for "no data": the one of the field, or NaN. Returns false and writes nothing if the field has none.
inline bool store_no_data(const Field& field, std::uint8_t* at) noexcept {
    if (field.type == Type::f32) {
        store(at, std::numeric_limits<float>::quiet_NaN(), field.order);
    } else if (field.type == Type::f64) {
        store(at, std::numeric_limits<double>::quiet_NaN(), field.order);
    } else if (field.no_data) {
        with_type(field.type, [&]<class T>(T) { store(at, static_cast<T>(*field.no_data), field.order); });
    } else {
        return false;
    }
    return true;
}

}    // namespace ano
