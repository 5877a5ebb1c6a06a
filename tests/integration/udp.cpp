// The UDP link with one fixed peer, which may be a broadcast address or a multicast group.
#include <link/udp/udp_settings.hpp>
#include <support/namespaces.hpp>
#include <support/open_network_beside.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

namespace udp_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

const Bytes telemetry = frame(0xDC, 0xFE, 0x03, {1, 2, 3, 4, 5, 6, 0});

/// `interface` may be empty.
anogate::LinkSettings on_interface(anogate::LinkSettings link, const std::string& interface) {
    link.as<anogate::UdpSettings>().interface = interface;
    return link;
}

void join(const UdpPeer& peer, const std::string& group) {
    const auto to = anogate::SocketAddress::of(endpoint(group), peer.local().address.v6);
    group_req request{};
    std::memcpy(&request.gr_group, &to.storage, sizeof to.storage);
    ASSERT_EQ(
        ::setsockopt(peer.fd(), peer.local().address.v6 ? IPPROTO_IPV6 : IPPROTO_IP, MCAST_JOIN_GROUP, &request, sizeof request),
        0);
}

TEST(UdpLink, serial_and_a_fixed_peer_exchange_vendor_bytes_unchanged) {
    const TempDir dir;
    PtyDevice mcu{dir / "ttyUSB0"};
    UdpPeer host;
    RunningGateway daemon{serial("mcu", mcu.path()), udp("host", host.local().text())};
    ASSERT_TRUE(daemon.until_up("mcu") && daemon.until_up("host"));
    host.send(daemon.port("host"), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return mcu.heard() == vendor::who_are_you; }));
    mcu.write(vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return host.heard() == vendor::i_am_an_mcu; }));
    EXPECT_EQ(host.last_sender().port, daemon.port("host"));
}

TEST(UdpLink, receives_only_from_its_peer) {
    UdpPeer host, stranger;
    RunningGateway daemon{udp("host", host.local().text())};
    stranger.send(daemon.port("host"), vendor::who_are_you);
    host.send(daemon.port("host"), vendor::command);
    EXPECT_TRUE(daemon.until([&] { return daemon.count("host", "frames_in") == 1; }));
    daemon.run_for(20ms);
    EXPECT_EQ(daemon.count("host", "bytes_in"), vendor::command.size());
}

TEST(UdpLink, shows_a_lost_peer_and_sends_to_it_again_when_it_returns) {
    auto peer = std::make_unique<UdpPeer>();
    const auto address = peer->local();
    UdpPeer air;
    RunningGateway daemon{udp("host", address.text()), udp_listen("air")};
    const auto send = [&] { air.send(daemon.port("air"), telemetry); };
    send();
    ASSERT_TRUE(daemon.until([&] { return peer->heard() == telemetry; }));
    peer.reset();
    EXPECT_TRUE(daemon.until([&] {
        send();
        return daemon.link("host").at("refused") > 3;
    }));
    EXPECT_EQ(daemon.link("host").at("state"), "up") << "a peer that is not there is no fault";
    EXPECT_EQ(daemon.link("host").at("error"), "connection refused: nothing listens at " + address.text());
    EXPECT_TRUE(daemon.counters_add_up());

    peer = std::make_unique<UdpPeer>(address.text());
    EXPECT_TRUE(daemon.until([&] {
        send();
        return !peer->heard().empty();
    }));
    EXPECT_TRUE(daemon.until([&] {
        send();
        return daemon.link("host").at("error") == "";
    })) << "it listens, though it never says a word";
    EXPECT_TRUE(split(peer->heard()).rest.empty());
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(UdpLink, bind_sets_the_source_address) {
    std::uint16_t port;
    {
        UdpPeer free;
        port = free.port();
    }
    UdpPeer host, air;
    auto link = udp("host", host.local().text());
    link.as<anogate::UdpSettings>().bind = endpoint("127.0.0.1:" + std::to_string(port));
    RunningGateway daemon{link, udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("host"));
    air.send(daemon.port("air"), telemetry);
    ASSERT_TRUE(daemon.until([&] { return host.heard() == telemetry; }));
    EXPECT_EQ(host.last_sender(), *link.as<anogate::UdpSettings>().bind);
}

TEST(UdpLink, waits_for_a_bound_port_in_use) {
    auto holder = std::make_unique<UdpPeer>();
    UdpPeer host;
    auto link = udp("host", host.local().text());
    link.as<anogate::UdpSettings>().bind = endpoint(holder->local().text());
    RunningGateway daemon{link};
    EXPECT_EQ(daemon.link("host").at("state"), "waiting");
    EXPECT_NE(daemon.link("host").at("error").get<std::string>().find("in use"), std::string::npos);
    holder.reset();
    EXPECT_TRUE(daemon.until_up("host"));
}

TEST(UdpLink, a_bound_ipv6_any_address_reaches_an_ipv4_peer) {
    UdpPeer host, air;
    auto link = udp("host", host.local().text());
    link.as<anogate::UdpSettings>().bind = endpoint("[::]:0");
    RunningGateway daemon{link, udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("host")) << daemon.link("host");
    air.send(daemon.port("air"), telemetry);
    EXPECT_TRUE(daemon.until([&] { return host.heard() == telemetry; }));
}

TEST(UdpLink, sends_and_receives_over_ipv6) {
    UdpPeer host{"[::1]:0"}, air;
    RunningGateway daemon{udp("host", host.local().text()), udp_listen("air")};
    host.send(daemon.port("host"), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return daemon.count("host", "frames_in") == 1; }));
    air.send(daemon.port("air"), telemetry);
    EXPECT_TRUE(daemon.until([&] { return host.heard() == telemetry; }));
}

TEST(UdpLink, joins_a_multicast_group_sends_to_it_and_receives_from_it) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    ASSERT_TRUE(network.run("link add va type veth peer name vb") && network.run("addr add 10.9.0.1/24 dev va") &&
                network.run("link set va up") && network.run("link set vb up") && network.run("route add 224.0.0.0/4 dev va"));
    UdpPeer member{"0.0.0.0:0"}, air;
    const std::string group = "239.1.2.3:" + std::to_string(member.port());
    join(member, group);
    auto link = udp("group", group);
    link.as<anogate::UdpSettings>().bind = endpoint("0.0.0.0:0");    // its own port: `member` uses the port of the group
    RunningGateway daemon{link, udp_listen("air", "127.0.0.1:0")};
    ASSERT_TRUE(daemon.until_up("group")) << daemon.link("group");
    air.send(daemon.port("air"), telemetry);
    EXPECT_TRUE(daemon.until([&] { return member.heard() == telemetry; }));
    daemon.run_for(20ms);
    EXPECT_EQ(daemon.count("group", "frames_in"), 0u) << "our own words, come back";

    auto to = endpoint(group);
    to.port = daemon.port("group");
    member.send(to, vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return daemon.count("group", "frames_in") == 1; }));
}

TEST(UdpLink, bind_selects_the_interface_of_a_multicast_group) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    ASSERT_TRUE(network.run("link add va type veth peer name vb") && network.run("addr add 10.9.0.1/24 dev va") &&
                network.run("link set va up") && network.run("link set vb up"));
    // bind= selects the interface by its address: there is no route for the group here.
    auto one = udp("group", "239.1.2.3:17000");
    one.as<anogate::UdpSettings>().bind = endpoint("10.9.0.1:17000");
    RunningGateway daemon{one, udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("group")) << daemon.link("group");
    UdpPeer other{"10.9.0.1:0"}, air;
    const auto interface = anogate::SocketAddress::of(endpoint("10.9.0.1:0"), false);
    sockaddr_in address;
    std::memcpy(&address, &interface.storage, sizeof address);
    ASSERT_EQ(::setsockopt(other.fd(), IPPROTO_IP, IP_MULTICAST_IF, &address.sin_addr, sizeof address.sin_addr), 0);
    ASSERT_TRUE(other.send(endpoint("239.1.2.3:17000"), vendor::who_are_you));
    EXPECT_TRUE(daemon.until([&] { return daemon.count("group", "frames_in") == 1; }));
}

TEST(UdpLink, interface_selects_the_interface_of_a_multicast_group) {
    ANOGATE_NEEDS_NAMESPACES();
    OpenNetworkBeside t;
    t.vehicle.ip("route add 224.0.0.0/4 dev wifi0");
    const auto daemon = t.gateway({on_interface(udp("group", "239.1.2.3:17000"), "wg0"), udp_listen("air")});
    const Inside inside{t.vehicle};
    ASSERT_TRUE(daemon->until_up("group")) << daemon->link("group");
    const auto ground = t.at(t.ground), stranger = t.at(t.stranger, "192.168.7.66:0");
    t.stranger.ip("route add 224.0.0.0/4 dev wifi0");
    t.ground.ip("route add 224.0.0.0/4 dev wg0");
    ASSERT_TRUE(stranger->send(endpoint("239.1.2.3:17000"), vendor::who_are_you));
    ASSERT_TRUE(ground->send(endpoint("239.1.2.3:17000"), vendor::who_are_you));
    ASSERT_TRUE(daemon->until([&] { return daemon->count("group", "frames_in") == 1; }));
    daemon->run_for(20ms);
    EXPECT_EQ(daemon->count("group", "frames_in"), 1u);
}

TEST(UdpLink, of_an_interface_ignores_its_peer_address_on_another_interface) {
    ANOGATE_NEEDS_NAMESPACES();
    OpenNetworkBeside t;
    const auto ground = t.at(t.ground, "10.77.0.2:6670"), stranger = t.at(t.stranger, "10.77.0.2:6670");
    const Inside inside{t.vehicle};
    for (const bool bound : {false, true}) {
        auto link = on_interface(udp("ground", "10.77.0.2:6670"), bound ? "wg0" : "");
        link.as<anogate::UdpSettings>().bind = endpoint("10.77.0.1:6669");
        const auto daemon = t.gateway({link});
        OpenNetworkBeside::expect_heard(*daemon, *ground, *stranger, "10.77.0.1:6669", bound);
    }
}

TEST(UdpLink, of_an_interface_sends_on_it_whatever_the_routes_are) {
    ANOGATE_NEEDS_NAMESPACES();
    OpenNetworkBeside t;
    for (const Namespace* space : {&t.ground, &t.stranger}) space->ip("address add 10.78.0.5/32 dev lo");
    t.vehicle.ip("route add 10.78.0.0/24 via 192.168.7.66 metric 10");
    t.vehicle.ip("route add 10.78.0.0/24 via 10.77.0.2 metric 20");
    const auto ground = t.at(t.ground, "10.78.0.5:6670"), stranger = t.at(t.stranger, "10.78.0.5:6670");
    const Inside inside{t.vehicle};
    for (const bool bound : {false, true}) {
        const auto daemon = t.gateway({on_interface(udp("far", "10.78.0.5:6670"), bound ? "wg0" : ""), udp_listen("air")});
        ASSERT_TRUE(daemon->until_up("far"));
        UdpPeer air;
        air.send(daemon->port("air"), telemetry);
        UdpPeer &meant = bound ? *ground : *stranger, &other = bound ? *stranger : *ground;
        EXPECT_TRUE(daemon->until([&] { return meant.heard() == telemetry; })) << (bound ? "bound" : "not bound");
        EXPECT_TRUE(other.heard().empty());
        meant.forget();
    }
}

TEST(UdpLink, of_an_interface_waits_for_it_and_uses_the_next_one_with_that_name) {
    ANOGATE_NEEDS_NAMESPACES();
    OpenNetworkBeside t;
    const auto daemon = t.gateway({on_interface(udp("ground", "10.77.0.2:6670"), "wg0"), udp_listen("air")});
    t.expect_ground_to_follow(*daemon);
    const Inside inside{t.vehicle};
    const auto ground = t.at(t.ground, "10.77.0.2:6670");
    UdpPeer air;
    EXPECT_TRUE(daemon->until([&] {
        air.send(daemon->port("air"), telemetry);
        return !ground->heard().empty();
    }));
}

TEST(UdpLink, receives_from_a_multicast_group_again_after_its_interface_was_replaced) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    const auto plug_in = [&] {
        return network.run("link add va type veth peer name vb") && network.run("addr add 10.9.0.1/24 dev va") &&
               network.run("link set va up") && network.run("link set vb up") && network.run("route add 224.0.0.0/4 dev va");
    };
    ASSERT_TRUE(plug_in());
    auto named = udp("named", "239.1.2.4:17001");
    named.as<anogate::UdpSettings>().bind = endpoint("10.9.0.1:17001");
    RunningGateway daemon{udp("routed", "239.1.2.3:17000"), named};
    ASSERT_TRUE(daemon.until_up("routed") && daemon.until_up("named"));
    for (int round = 0; round < 2; ++round) {
        ASSERT_TRUE(network.run("link del va") && plug_in());
        for (const auto& [name, group] : {std::pair{"routed", "239.1.2.3:17000"}, {"named", "239.1.2.4:17001"}}) {
            UdpPeer member{"10.9.0.1:0"};
            const auto before = daemon.count(name, "frames_in");
            EXPECT_TRUE(daemon.until([&, name = name, group = group] {
                member.send(endpoint(group), vendor::who_are_you);
                return daemon.count(name, "frames_in") > before;
            })) << daemon.link(name);
        }
    }
}

TEST(UdpLink, reports_a_multicast_group_without_a_route_and_suggests_to_name_an_interface) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    ASSERT_TRUE(network.run("link add va type veth peer name vb") && network.run("addr add 10.9.0.1/24 dev va") &&
                network.run("link set va up"));
    RunningGateway daemon{udp("group", "239.1.2.3:17000")};
    EXPECT_EQ(daemon.link("group").at("error"),
              "no route to the multicast group 239.1.2.3; name an interface: interface=NAME, or by its address "
              "bind=ADDRESS:17000");
}

TEST(UdpLink, receives_ipv6_multicast_on_an_interface) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    ASSERT_TRUE(network.run("link add va type veth peer name vb") && network.run("link set va up") &&
                network.run("link set vb up") && network.run("addr add fd00::1/64 dev va nodad") &&
                network.run("addr add fe80::1/64 dev va nodad"));
    RunningGateway daemon{udp("group", "[ff02::1234%va]:17000"), udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("group")) << daemon.link("group");
    UdpPeer member{"[fe80::1%va]:0"};
    ASSERT_TRUE(member.send(endpoint("[ff02::1234%va]:17000"), vendor::who_are_you));
    EXPECT_TRUE(daemon.until([&] { return daemon.count("group", "frames_in") == 1; }));
}

TEST(UdpLink, waits_for_an_absent_interface_and_accepts_it_with_a_new_index) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    RunningGateway daemon{udp("far", "[fe80::2%va]:17000"), udp_listen("near", "[fe80::1%va]:17001"), udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("air"));
    for (const int round : {1, 2}) {
        for (const char* link : {"far", "near"})
            EXPECT_EQ(daemon.link(link).at("error"), "network interface va not found") << round;
        ASSERT_TRUE(network.run("link add va type veth peer name vb" + std::to_string(round)) && network.run("link set va up") &&
                    network.run("link set vb" + std::to_string(round) + " up") &&
                    network.run("addr add fe80::1/64 dev va nodad") && network.run("addr add fe80::2/64 dev va nodad"));
        ASSERT_TRUE(daemon.until_up("far") && daemon.until_up("near")) << round;
        {
            UdpPeer far{"[fe80::2%va]:17000"}, air;
            // The link may be up before the second address exists: until then its datagrams are sent to the wire.
            EXPECT_TRUE(daemon.until([&] {
                air.send(daemon.port("air"), telemetry);
                const Bytes& heard = far.heard();
                return heard.size() >= telemetry.size() && std::equal(telemetry.rbegin(), telemetry.rend(), heard.rbegin());
            })) << round;
            EXPECT_TRUE(far.send(endpoint("[fe80::1%va]:17001"), vendor::who_are_you));
            EXPECT_TRUE(daemon.until([&] { return daemon.link("near").at("channels").size() == 1; })) << round;
        }
        ASSERT_TRUE(network.run("link del va"));
        EXPECT_TRUE(daemon.until([&] {
            return daemon.link("far").at("state") == "waiting" && daemon.link("near").at("state") == "waiting";
        })) << round;
    }
}

TEST(UdpLink, works_again_each_time_its_interface_is_replaced) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    const auto plug_in = [&] {
        return network.run("link add va type veth peer name vb") && network.run("link set va up") &&
               network.run("link set vb up") && network.run("addr add fe80::1/64 dev va nodad") &&
               network.run("addr add fe80::2/64 dev va nodad");
    };
    ASSERT_TRUE(plug_in());
    RunningGateway daemon{udp("far", "[fe80::2%va]:17000"), udp_listen("near", "[fe80::1%va]:17001")};
    ASSERT_TRUE(daemon.until_up("far") && daemon.until_up("near"));
    for (int round = 0; round < 3; ++round) {
        ASSERT_TRUE(network.run("link del va") && plug_in());    // between two checks: it is never seen absent
        UdpPeer peer{"[fe80::2%va]:17000"};
        for (const char* link : {"near", "far"}) {
            const auto before = daemon.count(link, "frames_in");
            EXPECT_TRUE(daemon.until([&] {
                const std::string there = daemon.link(link).value("address", "");    // the kernel chooses one of them
                if (!there.empty()) peer.send(endpoint(there), vendor::who_are_you);
                return daemon.count(link, "frames_in") > before;
            })) << round
                << daemon.link(link);
        }
    }
}

TEST(UdpLink, broadcast_reaches_all_listeners_and_is_not_received_by_the_sender) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    ASSERT_TRUE(network.run("link add va type veth peer name vb") && network.run("addr add 10.9.0.1/24 brd + dev va") &&
                network.run("link set va up") && network.run("link set vb up"));
    UdpPeer listener{"0.0.0.0:0"}, air;
    for (const char* address : {"10.9.0.255", "255.255.255.255"}) {
        network.run("route replace default dev va");    // 255.255.255.255 is sent on it
        auto link = udp("all", std::string{address} + ":" + std::to_string(listener.port()));
        link.as<anogate::UdpSettings>().bind = endpoint("0.0.0.0:0");
        RunningGateway daemon{link, udp_listen("air")};
        ASSERT_TRUE(daemon.until_up("all")) << daemon.link("all");
        listener.forget();
        air.send(daemon.port("air"), telemetry);
        EXPECT_TRUE(daemon.until([&] { return listener.heard() == telemetry; })) << address;
        listener.send(endpoint("10.9.0.1:" + std::to_string(daemon.port("all"))), vendor::who_are_you);
        EXPECT_TRUE(daemon.until([&] { return daemon.count("all", "frames_in") == 1; })) << "anybody may answer";
    }
}

TEST(UdpLink, waits_for_a_route_to_the_peer) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    RunningGateway daemon{udp("host", "192.0.2.9:6670")};
    EXPECT_EQ(daemon.link("host").at("state"), "waiting");
    EXPECT_EQ(daemon.link("host").at("error"), "can't reach 192.0.2.9:6670: Network is unreachable");
    ASSERT_TRUE(network.run("link add va type veth peer name vb") && network.run("addr add 192.0.2.1/24 dev va") &&
                network.run("link set va up") && network.run("link set vb up"));
    EXPECT_TRUE(daemon.until_up("host"));
}

TEST(UdpLink, the_address_of_its_interface_may_change) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    ASSERT_TRUE(network.run("link add va type veth peer name vb") && network.run("addr add 192.0.2.1/24 dev va") &&
                network.run("link set va up") && network.run("link set vb up"));
    UdpPeer air;
    RunningGateway daemon{udp("host", "192.0.2.9:6670"), udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("host"));
    EXPECT_EQ(daemon.link("host").at("address").get<std::string>().substr(0, 10), "192.0.2.1:");
    ASSERT_TRUE(network.run("addr del 192.0.2.1/24 dev va") && network.run("addr add 192.0.2.2/24 dev va"));
    EXPECT_TRUE(daemon.until([&] {
        air.send(daemon.port("air"), telemetry);
        return daemon.link("host").value("address", "").substr(0, 10) == "192.0.2.2:";
    })) << daemon.link("host");
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(UdpListenLink, waits_for_a_local_address_that_does_not_exist_yet) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    RunningGateway daemon{udp_listen("ground", "192.0.2.1:12333")};
    EXPECT_EQ(daemon.link("ground").at("state"), "waiting");
    EXPECT_EQ(daemon.link("ground").at("error"), "no network interface has the address 192.0.2.1");
    ASSERT_TRUE(network.run("addr add 192.0.2.1/32 dev lo"));
    ASSERT_TRUE(daemon.until_up("ground"));
    UdpPeer host{"192.0.2.1:0"};
    host.send(endpoint("192.0.2.1:12333"), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == 1; }));
}

TEST(UdpListenLink, a_network_that_an_interface_gets_later_is_allowed_then) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkNamespace network;
    RunningGateway daemon{udp_listen("ground", "0.0.0.0:0")};
    ASSERT_TRUE(network.run("addr add 192.0.2.1/24 dev lo"));
    UdpPeer host{"192.0.2.77:0"};    // the whole network is local on lo
    host.send(endpoint("192.0.2.1:" + std::to_string(daemon.port("ground"))), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == 1; }));
}

}    // namespace
}    // namespace udp_tests
