// The TCP door of the control interface, as the status tells of it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Where programs and browsers find the gateway, and what they need for it; never a token itself.
struct NetworkDoor {
    enum class State : std::uint8_t {
        off,        // none is configured
        waiting,    // for its address or port
        shut,       // for a fault of its tokens or its certificate, until the next start
        up,
    };
    State state = State::off;
    std::string error{};      // why it waits, or is shut
    std::string address{};    // as it is configured: "0.0.0.0", "::", "fe80::1%wlan0"
    std::uint16_t port = 0;
    bool is_encrypted = false;
    std::string certificate{};    // its whole path; empty: not encrypted
    bool needs_token = false;
    std::string token_file{};            // its whole path; empty: no tokens
    std::vector<std::string> hosts{};    // names that the configuration gives it
};

constexpr std::string_view text(NetworkDoor::State state) noexcept {
    constexpr std::string_view words[] = {"off", "waiting", "shut", "up"};
    return words[static_cast<std::size_t>(state)];
}

}    // namespace anogate
