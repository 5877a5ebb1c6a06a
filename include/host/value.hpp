// The value of a parameter or of a command, as a number or a text, and as bytes.
#pragma once
#include <ano/fault.hpp>
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

/// Why a value does not fit a type, as a clause that follows the value: "is not whole"; empty if it fits.
using Misfit = Fault;

/// Appends `value` in the form of `type` on the wire, never shorter than the type: a device would store check bytes in place of
/// the missing ones. A text is appended unchanged. Nothing is appended if the value does not fit.
Misfit append(std::vector<std::uint8_t>& out, const AnyValue& value, Type type);

/// `misfit` with the range of a number type: "is out of range, u8 is 0 to 255".
Misfit with_range(const Misfit& misfit, Type type);

/// The value in `bytes`; std::nullopt if there are too few. append() restores the same bytes, even for a NaN. Text ends at its
/// first NUL.
std::optional<AnyValue> value_of(Bytes bytes, Type type);

/// Whether both have the same bytes on the wire: NaNs of the same bits are equal, 0 and -0 are not. False if one does not fit.
bool same_bytes(const AnyValue& a, const AnyValue& b, Type type);

/// For people: 4, -0.25, "text".
std::string to_string(const AnyValue& value);

}    // namespace ano::host
