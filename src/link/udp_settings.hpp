// The settings of the two kinds of UDP links.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct UdpListenSettings {
    EndpointSpec local;
    std::string interface;    // nothing is heard or said by another; empty: by any
    ano::Duration peer_timeout = std::chrono::seconds{60};
    std::uint16_t max_peers = 16;
    std::optional<std::uint16_t> max_per_address;    // nothing: a quarter of max_peers, two at least
    bool allow_any = false;
    std::vector<Network> allow;    // empty and not allow_any: the networks of our interfaces
    bool trusted_any = false;
    std::vector<Network> trusted;    // outside the networks of our interfaces, yet sent to without limit
    bool operator==(const UdpListenSettings&) const = default;
};

struct UdpSettings {
    EndpointSpec peer;
    std::optional<EndpointSpec> bind;
    std::string interface;    // as of UdpListenSettings
    bool operator==(const UdpSettings&) const = default;
};

}    // namespace anogate
