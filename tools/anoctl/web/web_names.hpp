// The names and addresses at which HTTP of a gateway is available. No I/O.
#pragma once
#include <gateway/ip.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// The computer on which the gateway runs.
struct Computer {
    std::string name;                             // the host name; empty: none
    std::vector<anogate::IpAddress> addresses;    // of its interfaces
};

/// The endpoint on which the gateway listens.
struct WebAddress : anogate::Endpoint {
    bool is_encrypted = false;
    std::vector<std::string> hosts{};    // configured names
};

/// "vehicle", "vehicle.local"; of a name with a domain, "vehicle.lan", that name alone.
std::vector<std::string> names_of(const Computer& computer);

/// Addresses that work in browsers of other computers: neither loopback nor link-local.
std::vector<anogate::IpAddress> reachable(const Computer& computer);

/// "https://192.168.1.5:8088/": all URLs of the gateway. URLs with addresses are first, because they always work. If the gateway
/// listens on a loopback address, only the URLs for this computer.
std::vector<std::string> urls_of(const WebAddress& web_address, const Computer& computer);

/// The URL that works on most phones: the first of urls_of() without an IPv6 address, if there is one.
std::string url_for_phones(const WebAddress& web_address, const Computer& computer);

/// The URL for browsers on this computer.
std::string url_here(const WebAddress& web_address);

}    // namespace anoctl
