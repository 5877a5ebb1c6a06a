// A private network, and an open one where somebody uses its addresses.
#pragma once
#include "namespaces.hpp"
#include "running_gateway.hpp"
#include "udp_peer.hpp"

#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace support {

/// wg0 leads from the vehicle to the ground, wifi0 to the stranger; the kernel is no help.
struct OpenNetworkBeside {
    Namespace vehicle, ground, stranger;

    OpenNetworkBeside() {
        join_ground();
        vehicle.join(stranger, "wifi0", "192.168.7.1/24", "192.168.7.66/24");
        stranger.ip("address add 10.77.0.2/32 dev lo");
        stranger.ip("route add 10.77.0.1/32 via 192.168.7.1");
        const Inside inside{vehicle};
        for (const char* one : {"all", "default", "wifi0"}) std::ofstream{std::string{"/proc/sys/net/ipv4/conf/"} + one + "/rp_filter"} << 0;
    }
    void join_ground() { vehicle.join(ground, "wg0", "10.77.0.1/24", "10.77.0.2/24"); }
    /// The vehicle's; it is to be run inside.
    std::unique_ptr<RunningGateway> gateway(const std::vector<anogate::LinkSettings>& links) {
        const Inside inside{vehicle};
        return std::make_unique<RunningGateway>(settings_of(links));
    }
    /// The ground station, or the stranger under its address.
    std::unique_ptr<UdpPeer> at(const Namespace& space, const std::string& local = "10.77.0.2:0") {
        const Inside inside{space};
        return std::make_unique<UdpPeer>(local);
    }
};

}    // namespace support
