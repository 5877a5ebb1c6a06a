// The state of the TCP access to the control interface, for the status.
#pragma once
#include <sys/certificate_validity.hpp>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// The address at which programs and browsers reach the gateway, and the files that they need for it. It does not contain tokens.
struct ListenerInfo {
    enum class State : std::uint8_t {
        off,        // not configured
        waiting,    // for its address or port to become available
        shut,       // until a reload or the next start, because of a fault of its tokens or its certificate
        up,
    };
    static constexpr std::chrono::minutes lately{10};
    State state = State::off;
    std::string error{};      // why it waits, or is shut
    std::string address{};    // as configured: "0.0.0.0", "::", "fe80::1%wlan0"
    std::uint16_t port = 0;
    bool is_encrypted = false;
    std::string certificate{};    // absolute path; empty: not encrypted
    CertificateValidity validity{};
    bool needs_token = false;
    std::string token_file{};                                     // absolute path; empty: no tokens
    std::vector<std::string> hosts{};                             // configured names of this machine
    std::uint64_t wrong_tokens = 0;                               // received so far
    std::uint64_t guessing_clients = 0;                           // clients whose wrong tokens were slowed down
    std::uint64_t evicted = 0;                                    // waiting connections that were closed for others
    bool evicted_lately = false;                                  // within `lately`
    std::string_view link_code = "none", digits_code = "none";    // the state of the one-time codes
};

constexpr std::string_view text(ListenerInfo::State state) noexcept {
    constexpr std::string_view words[] = {"off", "waiting", "shut", "up"};
    return words[static_cast<std::size_t>(state)];
}

}    // namespace anogate
