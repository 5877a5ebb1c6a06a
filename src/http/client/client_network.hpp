// Which addresses count as one client.
#pragma once
#include <string>

namespace anogate::http {

/// Addresses with the same result count as one client: each IPv4 address; the first 64 bits of an IPv6 address, because a client can
/// use any number of addresses below them.
std::string client_network(const std::string& peer);

}    // namespace anogate::http
