// The settings of the two kinds of TCP links.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct TcpSettings {
    std::string peer;    // HostPort
    ano::Duration dead_after = std::chrono::seconds{10};
    bool operator==(const TcpSettings&) const = default;
};

struct TcpListenSettings {
    EndpointSpec local;
    ano::Duration dead_after = std::chrono::seconds{10};
    std::uint16_t max_peers = 16;
    std::optional<std::uint16_t> max_per_address;    // std::nullopt: a quarter of max_peers, at least 2
    bool allow_any = false;
    std::vector<Network> allow;    // empty without allow_any: the networks of our interfaces
    bool trusted_any = false;
    std::vector<Network> trusted;    // a quarter of the places is kept for them
    bool operator==(const TcpListenSettings&) const = default;
};

}    // namespace anogate
