// The settings of anogate-mqtt.
#pragma once
#include <ano/time.hpp>
#include <gateway/settings.hpp>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Which records the spool drops first when it is full.
enum class Keep : std::uint8_t { low, normal, high };
inline constexpr std::size_t keep_classes = 3;
inline constexpr std::string_view keep_names[keep_classes] = {"low", "normal", "high"};    // in the order of Keep

/// How a message is published. Of several rules for a message, the last one applies.
struct MessageRule {
    std::string message;    // its name or id; "*": all messages
    bool publish = true;
    std::uint32_t rate = 1000;    // thousandths of a message per second and device; 0: every frame
    std::uint32_t change = 0;     // thousandths of a unit, by which a number must change; 0: published without a change, too
    Keep keep = Keep::normal;

    bool operator==(const MessageRule&) const = default;
};

struct MqttSettings {
    std::string control;    // the socket of the gateway; empty: searched
    std::string broker;     // HOST:PORT
    std::string name;       // of the gateway in topics; empty: the name of the computer
    std::string username, password_file;
    std::string tls_ca, tls_certificate, tls_key;          // files; `tls_ca` empty: without TLS
    std::string spool;                                     // a folder; empty: the state folder
    std::uint64_t spool_size = std::uint64_t{64} << 20;    // bytes
    ano::Duration spool_age = std::chrono::hours{7 * 24};
    std::uint64_t backlog_rate = std::uint64_t{256} << 10;    // bytes per second
    ano::Duration will_delay = std::chrono::seconds{5};
    bool raw = false;
    std::vector<std::string> allow;    // "METHOD /PATH"
    std::vector<MessageRule> messages;
    LogSettings log;

    bool operator==(const MqttSettings&) const = default;
};

}    // namespace anogate
