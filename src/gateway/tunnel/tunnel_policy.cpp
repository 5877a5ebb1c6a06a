#include <gateway/tunnel/tunnel_policy.hpp>

#include <algorithm>

namespace anogate {
namespace {

const Network nowhere{IpAddress::v4(0, 0, 0, 0), 8};
const Network loopback{IpAddress::v4(127, 0, 0, 0), 8};
const Network multicast{IpAddress::v4(224, 0, 0, 0), 4};
const Network reserved{IpAddress::v4(240, 0, 0, 0), 4};

}    // namespace

bool TunnelPolicy::allows(const IpAddress& address) const noexcept {
    if (address.v6 || nowhere.contains(address)) return false;
    if (loopback.contains(address)) return lists(address, loopback);
    if (multicast.contains(address)) return lists(address, multicast);
    if (is_broadcast(address, networks_) || is_own(address)) return lists(address, {address, 32});
    if (reserved.contains(address)) return false;
    return contains(lists_nothing_ ? networks_ : allow_, address) ||
           std::find(hosts_.begin(), hosts_.end(), address) != hosts_.end();
}

bool TunnelPolicy::is_own(const IpAddress& address) const noexcept {
    return loopback.contains(address) ||
           std::any_of(networks_.begin(), networks_.end(), [&](const Network& n) { return n.address == address; });
}

bool TunnelPolicy::lists(const IpAddress& address, const Network& within) const noexcept {
    return std::any_of(allow_.begin(), allow_.end(),
                       [&](const Network& n) { return n.contains(address) && n.prefix >= within.prefix; });
}

const Network* listed_loopback(const std::vector<Network>& allow) noexcept {
    const auto network = std::find_if(
        allow.begin(), allow.end(), [](const Network& n) { return loopback.contains(n.address) && n.prefix >= loopback.prefix; });
    return network == allow.end() ? nullptr : &*network;
}

const Network* listed_own(const std::vector<Network>& allow, const std::vector<Network>& own) noexcept {
    const auto network = std::find_if(allow.begin(), allow.end(), [&](const Network& n) {
        const auto is_here = [&](const Network& one) { return one.address == n.address && !loopback.contains(n.address); };
        return n.prefix == 32 && std::any_of(own.begin(), own.end(), is_here);
    });
    return network == allow.end() ? nullptr : &*network;
}

}    // namespace anogate
