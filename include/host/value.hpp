// The value of a parameter or of a command, as a number or a text, and as bytes.
#pragma once
#include <ano/frame.hpp>
#include <ano/reading.hpp>
#include <ano/schema.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace ano::host {

using AnyValue = std::variant<std::int64_t, std::uint64_t, double, std::string>;

/// Why a value does not fit a type, as a clause behind the value: "is not whole"; nothing when it does.
using Misfit = std::string_view;

/// Appends `value` as `type` has it on the wire, never shorter than the type: a device would store check bytes in the place of what is
/// missing. A text is appended as it is. Nothing is appended when it does not fit.
Misfit append(std::vector<std::uint8_t>& out, const AnyValue& value, Type type);

/// What `misfit` says of a value, with the range of the type where this is why: "is out of range, u8 is 0 to 255".
std::string words_of_misfit(Misfit misfit, Type type);

/// The value that `bytes` are; nothing when there are too few. append() makes the same bytes of it, also of a NaN. Text is what
/// stands before the first NUL.
std::optional<AnyValue> value_of(Bytes bytes, Type type);

/// Whether both are the same bytes on the wire: a NaN is the same as one of the same bits, 0 is not -0. False where one does not fit.
bool same_bytes(const AnyValue& a, const AnyValue& b, Type type);

/// For people: 4, -0.25, "text".
std::string words_of(const AnyValue& value);

}    // namespace ano::host
