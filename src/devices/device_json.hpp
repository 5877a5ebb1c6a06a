// Devices and their values as JSON, in answers and requests.
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

/// The identity of a device: {"address": "0xDC", "name": …}; unknown parts are left out.
nlohmann::ordered_json identity_json(std::uint8_t address, const std::optional<ano::host::DeviceInfo>& info);
/// Reads it back; std::nullopt: there is no name.
std::optional<ano::host::DeviceInfo> identity_in(const nlohmann::ordered_json& json);
nlohmann::ordered_json device_json(const DeviceReport& report, ano::TimePoint now);

/// A number that is not finite becomes a text, "inf", "-inf" or "nan", which JSON has no numbers for.
nlohmann::ordered_json value_json(const ano::host::AnyValue& value, std::optional<ano::Type> type);
/// std::nullopt: not a value. For a number type, a text is read as a number.
std::optional<ano::host::AnyValue> value_in(const nlohmann::ordered_json& json, std::optional<ano::Type> type);

/// One parameter; with its value if that is known.
nlohmann::ordered_json parameter_json(const ano::host::ParameterInfo& info, const std::optional<ano::host::AnyValue>& value,
                                      bool with_value);

/// The parameter with the name or number `word`.
ano::host::Found parameter_called(const ano::host::Parameters& all, std::string_view word);

}    // namespace anogate
