// What is told of devices, and what clients say of them, as JSON.
#pragma once
#include <ano/schema.hpp>
#include <ano/time.hpp>
#include <devices/device_service.hpp>
#include <host/parameters.hpp>
#include <host/value.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

/// What a device says of itself: {"address": "0xDC", "name": …}; what is not known is not there.
nlohmann::ordered_json identity_json(std::uint8_t address, const std::optional<ano::host::DeviceInfo>& info);
/// The other way; nothing where it says no name.
std::optional<ano::host::DeviceInfo> identity_in(const nlohmann::ordered_json& json);
nlohmann::ordered_json device_json(const DeviceReport& report, ano::TimePoint now);

/// A number that is not finite is a text, "inf", "-inf" or "nan": JSON has no number for it.
nlohmann::ordered_json value_json(const ano::host::AnyValue& value, std::optional<ano::Type> type);
/// Nothing: it is no value. For a number type, a text is read as a number.
std::optional<ano::host::AnyValue> value_in(const nlohmann::ordered_json& json, std::optional<ano::Type> type);

/// Of one parameter, with its value where that is known.
nlohmann::ordered_json parameter_json(const ano::host::ParameterInfo& info, const std::optional<ano::host::AnyValue>& value,
                                      bool with_value);

/// The parameter that `word` stands for: its name, or its number.
ano::host::Found parameter_called(const ano::host::Parameters& all, std::string_view word);

}    // namespace anogate
