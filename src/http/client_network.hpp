// Whom the clients of a network count as.
#pragma once
#include <string>

namespace anogate::http {

/// Clients of which this is the same count as one: an IPv4 address is one client; of IPv6 the first 64 bits are, for a client has as
/// many addresses below them as it likes.
std::string client_network(const std::string& peer);

}    // namespace anogate::http
