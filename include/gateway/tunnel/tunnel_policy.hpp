// Which addresses the tunnel may send to, and which may send to it.
#pragma once
#include <gateway/ip.hpp>
#include <gateway/settings.hpp>

#include <utility>
#include <vector>

namespace anogate {

/// An ordinary host is allowed by the networks and hosts of `allow`, or if there are none, by the networks of our interfaces.
/// Other addresses must be listed explicitly: loopback by a network within 127.0.0.0/8, multicast by one within 224.0.0.0/4, a
/// broadcast address or one of our own as a single address (/32). A host name never allows them, because others choose its
/// address. 0.0.0.0/8 (which on Linux leads to this machine) and 240.0.0.0/4 are never allowed.
class TunnelPolicy {
public:
    explicit TunnelPolicy(const TunnelSettings& settings)
        : allow_{settings.allow}, lists_nothing_{settings.allow.empty() && settings.allow_hosts.empty()} {}

    /// The networks of our interfaces as they are now, loopback included.
    void set_networks(std::vector<Network> networks) { networks_ = std::move(networks); }

    /// The addresses of `allow_hosts` as they are now.
    void set_hosts(std::vector<IpAddress> hosts) { hosts_ = std::move(hosts); }

    bool allows(const IpAddress& address) const noexcept;
    /// Whether it is the address of an interface of ours, or otherwise leads to this machine.
    bool is_own(const IpAddress& address) const noexcept;

private:
    bool lists(const IpAddress& address, const Network& within) const noexcept;

    std::vector<Network> allow_;
    bool lists_nothing_;
    std::vector<IpAddress> hosts_;
    std::vector<Network> networks_;
};

/// The first network of `allow` that allows loopback, or one of the addresses of our interfaces in `own`; nullptr: none does.
const Network* listed_loopback(const std::vector<Network>& allow) noexcept;
const Network* listed_own(const std::vector<Network>& allow, const std::vector<Network>& own) noexcept;

}    // namespace anogate
