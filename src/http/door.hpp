// Where a connection came in.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace anogate::http {

/// What a client may, and what a path asks of him.
enum class Access : std::uint8_t {
    open,       // what nobody needs a token for: the page's own files, and to give a token
    view,       // look
    control,    // everything
};

/// "open", "view", "control"
std::string_view text(Access access) noexcept;

struct Door {
    bool is_network = false;    // TCP: a browser that another page misuses may be behind it
    bool is_encrypted = false;
    bool needs_token = false;    // else its clients may everything
    std::string local;           // the address of ours that was connected to, "192.168.1.5" or "fe80::1"
    std::uint16_t port = 0;
    std::string peer;    // the client's address
};

}    // namespace anogate::http
