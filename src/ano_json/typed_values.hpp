// Values with types, a text format for the bytes of a command or a parameter: "u16:100,i32:-5".
#pragma once
#include <ano/schema.hpp>
#include <ano_json/text.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace ano {

struct TypedValues {
    std::vector<std::uint8_t> bytes;
    std::vector<Type> types;
};

/// Whether `text` has the form of typed values, not of hex digits.
inline bool is_typed(std::string_view text) noexcept { return text.find(':') != text.npos; }

/// Numbers of the types u8 to f64, packed. `role` is Role::values (up to 8 of them) or Role::value (one, or "string:TEXT", in
/// `encoding`). Otherwise the error, in a clause.
std::variant<TypedValues, std::string> typed_values(std::string_view text, Role role, Encoding encoding);

}    // namespace ano
