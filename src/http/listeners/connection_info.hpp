// The listener that accepted a connection, and the addresses.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace anogate::http {

/// The access of a client, and the access that a path requires.
enum class Access : std::uint8_t {
    open,       // without a token: the files of the page, and sending a token
    view,       // read only
    control,    // everything
};

/// "open", "view", "control"
std::string_view text(Access access) noexcept;

struct ConnectionInfo {
    bool is_network = false;    // TCP: the client may be a browser that sends requests for a page of another site
    bool is_encrypted = false;
    bool needs_token = false;    // false: all its clients may do everything
    std::string local;           // the local address that the client connected to, "192.168.1.5" or "fe80::1"
    std::uint16_t port = 0;
    std::int32_t process = 0;    // the client's, at a Unix socket; 0: not known
    std::string peer;            // the client's address
};

}    // namespace anogate::http
