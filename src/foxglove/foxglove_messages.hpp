// The messages of the Foxglove WebSocket protocol, v1: parses those of clients and makes those of the server. No I/O.
#pragma once
#include <record/decoded_channels.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate::foxglove {

/// The two names of the subprotocol, which does not differ between them for the messages in this file.
inline constexpr std::array<std::string_view, 2> subprotocols{"foxglove.sdk.v1", "foxglove.websocket.v1"};

/// The severity of a status message.
enum class Level : std::uint8_t { info, warning, error };

struct Subscription {
    std::uint32_t id = 0;    // chosen by the client
    std::uint32_t channel = 0;
};

/// A parameter of a device, under a unique name: "fc/220/PID_ROLL_P".
struct Parameter {
    std::string name;
    std::string value;    // JSON: a number or a text
    bool operator==(const Parameter&) const = default;
};

// Messages from a client.
struct Subscribe {
    std::vector<Subscription> subscriptions;
};
struct Unsubscribe {
    std::vector<std::uint32_t> ids;
};
struct GetParameters {
    std::vector<std::string> names;    // empty: all known parameters
    std::optional<std::string> id;     // of the request, repeated in the response
};
struct WatchParameters {
    std::vector<std::string> names;    // empty: all
    bool ends = false;                 // unsubscribe
};
struct Wrong {
    std::string words;    // a clause: the error in the message, or why it is refused
};
using ClientMessage = std::variant<Subscribe, Unsubscribe, GetParameters, WatchParameters, Wrong>;

ClientMessage read(std::string_view text);

struct ServerInfo {
    std::string name;
    std::string session;    // differs after each start of the gateway
};
std::string server_info(const ServerInfo& server);

struct Channel {
    std::uint32_t id = 0;
    std::string_view topic, encoding, schema_name, schema, schema_encoding;
};
std::string advertise(std::span<const Channel> channels);
std::string unadvertise(std::span<const std::uint32_t> channels);
std::string status(Level level, std::string_view words);
/// Each value is complete JSON.
std::string parameter_values(std::span<const Parameter> parameters, const std::optional<std::string>& id);
/// A binary message with the payload of a channel.
std::string message_data(std::uint32_t subscription, std::uint64_t time_ns, std::string_view payload);

}    // namespace anogate::foxglove
