// The values of parameters and commands, whose types are defined by other messages (protocol text, section 4).
#pragma once
#include <ano/schema.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace ano {

/// The meaning of type 7 in command_info (0xC2): f32 in the protocol text, u64 in current devices.
enum class ValueType7 : std::uint8_t { f32, u64 };

/// The type for par_type of parameter_info (0xE2): a number type for 0 to 9, `text` for 10, else std::nullopt.
constexpr std::optional<Type> parameter_type(std::uint64_t par_type) noexcept {
    if (par_type == 10) return Type::text;
    if (par_type > 10) return std::nullopt;
    return static_cast<Type>(par_type);    // u8 to f64 in the order of Type
}

/// The type for an element of val_type of command_info; std::nullopt for 0 (no value) and for unlisted numbers.
constexpr std::optional<Type> command_value_type(std::uint64_t val_type, ValueType7 seven) noexcept {
    constexpr std::array types{Type::u8,  Type::i8,  Type::u16, Type::i16, Type::u32,
                               Type::i32, Type::u64, Type::i64, Type::f32, Type::f64};
    if (val_type == 0 || val_type > types.size()) return std::nullopt;
    if (val_type == 7 && seven == ValueType7::f32) return Type::f32;
    return types[static_cast<std::size_t>(val_type - 1)];
}

/// Whether `size` bytes can be the value of a parameter_value (0xE1). If a device receives fewer bytes than the type has, it
/// stores the check bytes of the frame in place of the missing ones. Without `type`: whether it is the size of some number, or
/// longer.
constexpr bool is_whole_value(std::size_t size, std::optional<Type> type) noexcept {
    if (size == 0) return false;
    if (type) return *type == Type::text || size >= width(*type);
    return size == 1 || size == 2 || size == 4 || size >= 8;
}

}    // namespace ano
