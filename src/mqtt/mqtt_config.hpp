// Reads and prints the configuration of anogate-mqtt, by the rules of that of anogated: comments are allowed, unknown keys are errors.
#pragma once
#include <config/config_error.hpp>
#include <config/keys.hpp>
#include <mqtt/settings.hpp>

#include <cstdint>
#include <string>
#include <string_view>

namespace anogate {

Keys<MessageRule> message_rule_keys() noexcept;
/// Without "messages", a list of objects with the message_rule_keys(), and "log".
Keys<MqttSettings> mqtt_keys() noexcept;

/// Adds the configuration in `json` to `settings`. `file` is the prefix of the places of errors, "" for none.
void read_mqtt_config(std::string_view json, const std::string& file, MqttSettings& settings, ConfigErrors& errors);
/// What must be true of the whole, once the command line was added.
void check_mqtt_settings(const MqttSettings& settings, ConfigErrors& errors);

/// An equivalent configuration file.
std::string print_mqtt_config(const MqttSettings& settings);
/// The JSON Schema (draft 7).
std::string mqtt_config_schema();

/// The host and the port of a broker, "HOST:PORT" or "[IPV6]:PORT".
struct BrokerAddress {
    std::string host;
    std::uint16_t port = 0;    // 0: `text` is neither
};
BrokerAddress broker_address(std::string_view text);

}    // namespace anogate
