// The messages of the Foxglove WebSocket protocol, v1: what its clients say, read, and what they are told, made. No I/O.
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

/// The two names that its subprotocol has; they say the same of all that is here.
inline constexpr std::array<std::string_view, 2> subprotocols{"foxglove.sdk.v1", "foxglove.websocket.v1"};

/// How bad what a status says is.
enum class Level : std::uint8_t { info, warning, error };

struct Subscription {
    std::uint32_t id = 0;    // the client chose it
    std::uint32_t channel = 0;
};

/// A parameter of a device, by a name of its own: "fc/220/PID_ROLL_P".
struct Parameter {
    std::string name;
    std::string value;    // JSON: a number or a text
    bool operator==(const Parameter&) const = default;
};

// What a client says.
struct Subscribe {
    std::vector<Subscription> subscriptions;
};
struct Unsubscribe {
    std::vector<std::uint32_t> ids;
};
struct GetParameters {
    std::vector<std::string> names;    // none: all that are known
    std::optional<std::string> id;     // of the question, that the answer bears
};
struct WatchParameters {
    std::vector<std::string> names;    // none: all
    bool ends = false;                 // they are watched no longer
};
struct Wrong {
    std::string words;    // in a clause: what is wrong with it, or why it is not done
};
using Said = std::variant<Subscribe, Unsubscribe, GetParameters, WatchParameters, Wrong>;

Said read(std::string_view text);

struct ServerInfo {
    std::string name;
    std::string session;    // another one after each start of the gateway
};
std::string server_info(const ServerInfo& server);

struct Channel {
    std::uint32_t id = 0;
    std::string_view topic, encoding, schema_name, schema, schema_encoding;
};
std::string advertise(std::span<const Channel> channels);
std::string unadvertise(std::span<const std::uint32_t> channels);
std::string status(Level level, std::string_view words);
/// `values` are complete JSON each.
std::string parameter_values(std::span<const Parameter> parameters, const std::optional<std::string>& id);
/// Binary: what stands on a channel.
std::string message_data(std::uint32_t subscription, std::uint64_t time_ns, std::string_view payload);

}    // namespace anogate::foxglove
