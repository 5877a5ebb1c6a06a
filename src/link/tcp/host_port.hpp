// Where a connection goes: a host name or an IP address, and a port.
#pragma once
#include <gateway/ip.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

struct HostPort {
    std::string host{};    // a name; empty when `literal` is set
    std::uint16_t port = 0;
    std::optional<EndpointSpec> literal{};    // an address, maybe with the name of an interface

    /// "fc.local:8080", "192.168.4.1:8080", "[fe80::1%wlan0]:8080"; the port is 1 to 65535. std::nullopt for anything else.
    static std::optional<HostPort> parse(std::string_view text);
};

}    // namespace anogate
