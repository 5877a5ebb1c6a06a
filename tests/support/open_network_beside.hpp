// A private network, and an open one in which a stranger uses the addresses of the private one.
#pragma once
#include "namespaces.hpp"
#include "running_gateway.hpp"
#include "udp_peer.hpp"
#include "vendor_frames.hpp"

#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace support {

/// wg0 connects the vehicle to the ground, wifi0 to the stranger; the kernel does not filter by source address.
struct OpenNetworkBeside {
    Namespace vehicle, ground, stranger;

    OpenNetworkBeside() {
        join_ground();
        vehicle.join(stranger, "wifi0", "192.168.7.1/24", "192.168.7.66/24");
        stranger.ip("address add 10.77.0.2/32 dev lo");
        stranger.ip("route add 10.77.0.1/32 via 192.168.7.1");
        const Inside inside{vehicle};
        for (const char* one : {"all", "default", "wifi0"})
            std::ofstream{std::string{"/proc/sys/net/ipv4/conf/"} + one + "/rp_filter"} << 0;
    }
    void join_ground() { vehicle.join(ground, "wg0", "10.77.0.1/24", "10.77.0.2/24"); }
    /// A gateway in the namespace of the vehicle. The test must run it there.
    std::unique_ptr<RunningGateway> gateway(const std::vector<anogate::LinkSettings>& links) {
        const Inside inside{vehicle};
        return std::make_unique<RunningGateway>(settings_of(links));
    }
    /// A socket of the ground station, or of the stranger with the same address.
    std::unique_ptr<UdpPeer> at(const Namespace& space, const std::string& local = "10.77.0.2:0") {
        const Inside inside{space};
        return std::make_unique<UdpPeer>(local);
    }
    /// The stranger sends three frames, then the ground station one, to `port` of the link "ground". The link must receive only
    /// the frame over wg0 if it is `bound` to that, otherwise all.
    static void expect_heard(RunningGateway& daemon, UdpPeer& ground, UdpPeer& stranger, const std::string& port, bool bound) {
        const auto to = endpoint(port);
        ASSERT_TRUE(daemon.until_up("ground"));
        for (int i = 0; i < 3; ++i) stranger.send(to, vendor::who_are_you);
        ground.send(to, vendor::who_are_you);
        const std::uint64_t heard = bound ? 1 : 4;
        ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") >= heard; }))
            << (bound ? "bound: " : "not bound: ") << daemon.link("ground").dump();
        EXPECT_EQ(daemon.count("ground", "frames_in"), heard) << "the stranger's datagrams were there first";
    }
    /// Removes wg0 and creates it again; the link "ground", which is bound to it, must go down and up.
    void expect_ground_to_follow(RunningGateway& daemon) {
        ASSERT_TRUE(daemon.until_up("ground"));
        vehicle.ip("link delete wg0");
        {
            const Inside inside{vehicle};
            ASSERT_TRUE(daemon.until_waiting("ground"));
        }
        EXPECT_EQ(daemon.link("ground").at("error"), "network interface wg0 not found");
        join_ground();
        const Inside inside{vehicle};
        ASSERT_TRUE(daemon.until_up("ground"));
    }
};

}    // namespace support
