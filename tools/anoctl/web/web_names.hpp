// The names and addresses under which a gateway is reached by HTTP. No I/O.
#pragma once
#include <gateway/ip.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// The computer of the gateway.
struct Computer {
    std::string name;                             // the host name; empty: it has none
    std::vector<anogate::IpAddress> addresses;    // of its interfaces
};

/// The endpoint where the gateway listens.
struct WebDoor : anogate::Endpoint {
    bool is_encrypted = false;
    std::vector<std::string> hosts{};    // configured names
};

/// "vehicle", "vehicle.local".
std::vector<std::string> names_of(const Computer& computer);

/// Addresses that other computers can type into a browser: neither loopback nor link-local ones.
std::vector<anogate::IpAddress> reachable(const Computer& computer);

/// "https://192.168.1.5:8088/": all URLs of the gateway, those with addresses first, since they always work. When it listens on a loopback
/// address, only those for this computer.
std::vector<std::string> urls_of(const WebDoor& door, const Computer& computer);

/// The URL that phones reach most likely: the first of urls_of() without an IPv6 address, if there is one.
std::string url_for_phones(const WebDoor& door, const Computer& computer);

/// The URL on this computer itself.
std::string url_here(const WebDoor& door);

}    // namespace anoctl
