// The configured address of a peer: an IP address, or a host name that is resolved when it is needed.
#pragma once
#include <gateway/ip.hpp>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

/// Letters, digits, '-', '_' and dots, within the limits of DNS. False for numbers and dots alone, also hexadecimal ones:
/// they are a mistyped IP address, which the resolver may accept (127.1, 0x7f000001).
bool is_host_name(std::string_view text) noexcept;

/// Names of DNS: upper and lower case are the same, and a dot at the end is not part of the name.
bool is_same_name(std::string_view a, std::string_view b) noexcept;

/// The addresses of names, as far as they are known.
using HostAddresses = std::map<std::string, std::vector<IpAddress>, std::less<>>;

/// If `host` is set, `address` is empty and only `port` is used.
struct HostSpec : EndpointSpec {
    std::string host{};

    HostSpec() = default;
    HostSpec(EndpointSpec endpoint) : EndpointSpec{std::move(endpoint)} {}

    /// As EndpointSpec::parse(), or "flow.local:8888".
    static std::optional<HostSpec> parse(std::string_view text);
    std::string text() const;
    /// Whether its packets stay on this computer, as far as the text shows.
    bool is_here() const noexcept { return host.empty() ? address.is_loopback() : is_same_name(host, "localhost"); }
    friend bool operator==(const HostSpec& a, const HostSpec& b) noexcept {
        return static_cast<const EndpointSpec&>(a) == static_cast<const EndpointSpec&>(b) && is_same_name(a.host, b.host);
    }
};

}    // namespace anogate
