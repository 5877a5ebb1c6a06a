// The state of a gateway as JSON (the shape is part of the interface: tools/README.md, "The status").
#pragma once
#include <status/listener_info.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace anogate {

class Gateway;

/// GET /status: one JSON text. `listener`: the TCP access; `lost`: the devices that are lost, if that is known.
std::string status_json(Gateway& gateway, const ListenerInfo& listener = {}, const nlohmann::ordered_json* lost = nullptr);
/// GET /links, GET /routes: only this array of the status.
std::string links_json(Gateway& gateway);
std::string routes_json(Gateway& gateway);
/// GET /messages: the table of messages, with the flexible messages as configured.
std::string messages_json(const Gateway& gateway);
/// The status in a few lines for the log.
std::string status_text(Gateway& gateway);

/// The valid frames of all links since the start.
struct FrameCount {
    std::uint64_t in = 0, out = 0;
};
FrameCount frame_count(const Gateway& gateway);

/// The log lines of hints, and of damage in a recording that is replayed: each once while its link is up.
class HintLog {
public:
    /// One line for each hint that was not returned yet.
    std::vector<std::string> news(Gateway& gateway);
    /// To be called when the link of this name was replaced or removed.
    void forget(const std::string& link) { logged_hints_.erase(link); }

private:
    std::map<std::string, std::set<std::string>> logged_hints_;    // by link
};

}    // namespace anogate
