#include <http/client/client_network.hpp>

#include <arpa/inet.h>
#include <netinet/in.h>

namespace anogate::http {

std::string client_network(const std::string& peer) {
    in6_addr address{};
    if (::inet_pton(AF_INET6, peer.substr(0, peer.find('%')).c_str(), &address) != 1) return peer;
    return {reinterpret_cast<const char*>(address.s6_addr), 8};
}

}    // namespace anogate::http
