// IP addresses, networks and endpoints as values, parsed from text and written as text. No host names, no sockets. A link-local
// address may have the name of an interface.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// IPv4 or IPv6. An IPv4 address mapped into IPv6 (::ffff:a.b.c.d) is stored as the IPv4 address.
struct IpAddress {
    bool v6 = false;
    std::array<std::uint8_t, 16> bytes{};    // in network byte order; IPv4 uses the first four
    std::uint32_t scope = 0;                 // interface index of a link-local IPv6 address, 0 for none

    static IpAddress v4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) noexcept {
        return {false, {a, b, c, d}, 0};
    }
    /// Dotted or colon text, with `%interface` after a link-local one. std::nullopt for anything else, such as host names.
    static std::optional<IpAddress> parse(std::string_view text);
    std::string text() const;

    bool is_any() const noexcept;
    bool is_loopback() const noexcept;
    /// 169.254.0.0/16, fe80::/10 and the multicast groups of one link: in IPv6 they need a scope.
    bool is_link_local() const noexcept;
    bool is_multicast() const noexcept;
    friend bool operator==(const IpAddress&, const IpAddress&) = default;
};

struct Endpoint {
    IpAddress address;
    std::uint16_t port = 0;

    /// "192.168.1.20:6670" or "[fe80::1%wlan0]:6670".
    static std::optional<Endpoint> parse(std::string_view text);
    std::string text() const;
    friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// An endpoint as it is configured. The interface of a link-local address is stored by name, since interfaces appear and
/// disappear, and their numbers change. `address.scope` is 0.
struct EndpointSpec : Endpoint {
    std::string interface {};    // 1 to 15 bytes, or its number; empty for none

    /// As Endpoint::parse(), but the interface need not exist now.
    static std::optional<EndpointSpec> parse(std::string_view text);
    std::string text() const;
    friend bool operator==(const EndpointSpec&, const EndpointSpec&) = default;
};

/// An address and the number of its leading bits that count.
struct Network {
    IpAddress address;
    std::uint8_t prefix = 0;    // 0 to 32, or 0 to 128

    /// "192.168.0.0/24"; without a prefix, that one address.
    static std::optional<Network> parse(std::string_view text);
    std::string text() const;
    bool contains(const IpAddress& other) const noexcept;
    friend bool operator==(const Network&, const Network&) = default;
};

/// IPv4: 255.255.255.255, or the first or last address of one of `networks`, which address every host there.
bool is_broadcast(const IpAddress& address, const std::vector<Network>& networks) noexcept;

bool contains(const std::vector<Network>& networks, const IpAddress& address) noexcept;

}    // namespace anogate
