// Under which names and addresses a gateway is found by HTTP: arithmetic, no I/O.
#pragma once
#include <gateway/ip.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// The computer that it runs on.
struct Computer {
    std::string name;                             // of the host; empty: it has none
    std::vector<anogate::IpAddress> addresses;    // of its interfaces
};

/// Where it listens.
struct WebDoor : anogate::Endpoint {
    bool is_encrypted = false;
    std::vector<std::string> hosts{};    // names that the configuration gives it
};

/// "vehicle", "vehicle.local".
std::vector<std::string> names_of(const Computer& computer);

/// Addresses that others can reach and write into a browser: neither of a loopback, nor of one link alone.
std::vector<anogate::IpAddress> reachable(const Computer& computer);

/// "https://192.168.1.5:8088/": every way to it, addresses first, for they always work; of a loopback address, those of this
/// computer alone.
std::vector<std::string> urls_of(const WebDoor& door, const Computer& computer);

/// The way to it on this computer itself.
std::string url_here(const WebDoor& door);

}    // namespace anoctl
