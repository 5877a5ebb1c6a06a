// The networks of our interfaces, cached for a second: reading them takes a system call for each interface.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>
#include <link/udp/ip_socket.hpp>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

namespace anogate {

class OwnNetworks {
public:
    static constexpr ano::Duration age = std::chrono::seconds{1};    // interfaces may be added, removed or changed

    /// Reads the networks when they are older than `age`. True: they were read. If the system returns none, the previous ones are
    /// kept.
    bool refresh(ano::TimePoint now) {
        if (read_at_ != ano::TimePoint{} && now - read_at_ < age) return false;
        read_at_ = now;
        if (auto all = own_networks(); !all.empty()) all_ = std::move(all);
        return true;
    }
    /// As of the last refresh().
    const std::vector<Network>& all() const noexcept { return all_; }

    /// Whether `address` is in one of the networks.
    bool contain(const IpAddress& address, ano::TimePoint now) {
        refresh(now);
        return contains(all_, address);
    }
    /// Whether `address` is that of one of our interfaces.
    bool have(const IpAddress& address, ano::TimePoint now) {
        refresh(now);
        return std::any_of(all_.begin(), all_.end(), [&](const Network& network) { return network.address == address; });
    }

private:
    std::vector<Network> all_;
    ano::TimePoint read_at_{};
};

}    // namespace anogate
