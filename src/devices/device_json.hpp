// Devices and their values as JSON, in answers and requests.
#pragma once
#include <ano/schema.hpp>
#include <ano/time.hpp>
#include <ano/values.hpp>
#include <devices/device_service.hpp>
#include <devices/device_texts.hpp>
#include <host/parameters.hpp>
#include <host/value.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// The identity of a device: {"address": "0xDC", "name": …}; unknown parts are left out.
nlohmann::ordered_json identity_json(std::uint8_t address, const std::optional<ano::host::DeviceInfo>& info,
                                     const DeviceTexts& texts);
/// Parses the output of identity_json(); std::nullopt: there is no name.
std::optional<ano::host::DeviceInfo> identity_in(const nlohmann::ordered_json& json);
inline constexpr std::string_view encoding_hint =
    "its texts are GBK, not UTF-8, but its link has encoding=utf8: remove that key, or set encoding=gbk";
nlohmann::ordered_json device_json(const DeviceReport& report, ano::TimePoint now);

/// A number that is not finite becomes a text, "inf", "-inf" or "nan", since JSON has no such numbers.
nlohmann::ordered_json value_json(const ano::host::AnyValue& value, std::optional<ano::Type> type, const DeviceTexts& texts = {});
/// std::nullopt: not a value. For a number type, a text is parsed as a number. Other texts stay as the client sent them, see
/// DeviceTexts::wire().
std::optional<ano::host::AnyValue> value_in(const nlohmann::ordered_json& json, std::optional<ano::Type> type);

/// "f32" or "u64".
std::string_view to_string(ano::ValueType7 seven) noexcept;
/// std::nullopt: neither.
std::optional<ano::ValueType7> value_type_7_in(const nlohmann::ordered_json& json);

/// One parameter; with its value if that is known.
nlohmann::ordered_json parameter_json(const ano::host::ParameterInfo& info, const std::optional<ano::host::AnyValue>& value,
                                      bool with_value, const DeviceTexts& texts);

}    // namespace anogate
