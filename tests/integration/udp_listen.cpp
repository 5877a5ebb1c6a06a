// The listening UDP link: which senders are accepted as peers, for how long, and the frames that each receives.
#include <link/udp/udp_settings.hpp>
#include <support/namespaces.hpp>
#include <support/open_network_beside.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <fstream>

namespace udp_listen_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

std::size_t peers(RunningGateway& daemon, const std::string& link = "ground") { return daemon.link(link).at("channels").size(); }

const Bytes telemetry = frame(0xDC, 0xFE, 0x03, {1, 2, 3, 4, 5, 6, 0});

// Frames for the peers of the first listening link are received on a second one.
struct TwoLinks {
    RunningGateway daemon{udp_listen("ground"), udp_listen("air")};
    UdpPeer air;
    void send(const Bytes& bytes) { air.send(daemon.port("air"), bytes); }
};

TEST(UdpListenLink, registers_a_peer_only_after_one_complete_valid_frame) {
    TwoLinks t;
    UdpPeer host;
    const auto port = t.daemon.port("ground");
    Bytes damaged = telemetry;
    damaged.back() ^= 1;
    host.send(port, Bytes{});
    host.send(port, Bytes(100, 0x55));
    host.send(port, damaged);
    host.send(port, std::span{telemetry}.first(10));
    ASSERT_TRUE(t.daemon.until([&] { return t.daemon.count("ground", "bytes_in") == 100 + damaged.size() + 10; }));
    EXPECT_EQ(peers(t.daemon), 0u);
    EXPECT_EQ(t.daemon.count("ground", "bad_check"), 1u);
    EXPECT_EQ(t.daemon.count("ground", "frames_in"), 0u);
    EXPECT_TRUE(t.daemon.status().at("routes").empty()) << "no address is learned from junk";

    host.send(port, telemetry);
    EXPECT_TRUE(t.daemon.until([&] { return peers(t.daemon) == 1; }));
    EXPECT_EQ(t.daemon.link("ground").at("channels").at(0).at("peer"), host.local().text());
    EXPECT_EQ(t.daemon.count("ground", "frames_in"), 1u);
}

TEST(UdpListenLink, does_not_register_a_link_of_the_same_gateway_as_a_peer) {
    std::string ground_at;
    {
        const UdpPeer free;
        ground_at = free.local().text();
    }
    const auto ground = udp_listen("ground", ground_at);
    const auto own = udp("own", ground_at);
    RunningGateway daemon{ground, own, sim("fc", 50)};
    EXPECT_TRUE(daemon.until([&] { return daemon.count("ground", "denied_in") > 3; }));
    EXPECT_EQ(daemon.link("ground").at("channels").size(), 0u);
}

TEST(UdpListenLink, every_peer_has_a_separate_channel) {
    TwoLinks t;
    UdpPeer first, second, third;
    const auto port = t.daemon.port("ground");
    for (UdpPeer* p : {&first, &second, &third}) p->send(port, frame(0xFE, 0xDC, 0xE0, {1, 0, 0}));
    ASSERT_TRUE(t.daemon.until([&] { return peers(t.daemon) == 3; }));
    for (UdpPeer* p : {&first, &second, &third}) p->forget();
    // Three hosts, all 0xFE: each receives a frame for 0xFE once.
    t.send(telemetry);
    for (UdpPeer* p : {&first, &second, &third}) EXPECT_TRUE(t.daemon.until([&] { return p->heard() == telemetry; }));
    const auto link = t.daemon.link("ground");
    for (const auto& channel : link.at("channels")) {
        EXPECT_EQ(channel.at("frames_in"), 1);
        EXPECT_GE(channel.at("frames_out"), 1);
    }
    EXPECT_TRUE(t.daemon.counters_add_up());
}

TEST(UdpListenLink, forwards_frames_between_its_peers) {
    RunningGateway daemon{udp_listen("ground")};
    UdpPeer fc, host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    fc.send(daemon.port("ground"), vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return host.heard() == vendor::i_am_an_mcu; }));
    host.send(daemon.port("ground"), vendor::write_parameter);
    EXPECT_TRUE(daemon.until([&] { return fc.heard() == vendor::write_parameter; }));
    EXPECT_EQ(host.heard(), vendor::i_am_an_mcu) << "never back to where it came from";
}

TEST(UdpListenLink, a_silent_peer_is_forgotten) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().peer_timeout = 200ms;
    RunningGateway daemon{link};
    UdpPeer device;
    device.send(daemon.port("ground"), vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 1; }));
    EXPECT_FALSE(daemon.route("0xDB").is_null());
    EXPECT_TRUE(daemon.until([&] { return peers(daemon) == 0; }));
    EXPECT_TRUE(daemon.route("0xDB").is_null()) << "an address is forgotten with its channel";
    EXPECT_EQ(daemon.count("ground", "frames_in"), 1u) << "counters of a link never decrease";
    device.send(daemon.port("ground"), vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return peers(daemon) == 1; })) << "and comes back when it speaks";
    EXPECT_EQ(daemon.count("ground", "frames_in"), 2u);
}

TEST(UdpListenLink, keeps_the_counters_of_a_removed_peer) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().peer_timeout = 300ms;
    link.rules.send.deny = {{0x06, 0x06}};
    RunningGateway daemon{link, udp_listen("air")};
    UdpPeer first, second, air;
    for (UdpPeer* peer : {&first, &second}) peer->send(daemon.port("ground"), vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 2; }));
    air.send(daemon.port("air"), frame(0xDC, 0xFF, 0x03, {1, 2, 3, 4, 5, 6, 0}) + frame(0xDC, 0xFF, 0x06, Bytes(4, 0)));
    ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "denied_out") >= 2; }));    // all earlier frames were sent
    const auto link_then = daemon.link("ground");
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 0; }));
    for (const char* counter : {"frames_in", "bytes_in", "frames_out", "bytes_out", "denied_out"})
        EXPECT_EQ(daemon.count("ground", counter), link_then.at(counter)) << counter;
    EXPECT_GE(daemon.count("ground", "denied_out"), 2u);
    EXPECT_TRUE(daemon.counters_add_up());
}

// The peer that is due first is checked first, in whatever order they joined.
TEST(UdpListenLink, partial_frames_of_several_peers_expire_independently) {
    TwoLinks t;
    UdpPeer one, two, host;
    for (UdpPeer* peer : {&one, &two}) peer->send(t.daemon.port("ground"), vendor::i_am_an_mcu);
    t.send(telemetry);
    ASSERT_TRUE(t.daemon.until([&] { return peers(t.daemon) == 2 && t.daemon.count("air", "frames_in") == 1; }));
    const auto expired = [&](const UdpPeer& peer) {
        const auto link = t.daemon.link("ground");
        for (const auto& channel : link.at("channels"))
            if (channel.at("peer") == peer.local().text())
                return channel.at("expired").get<int>() + channel.at("skipped_bytes").get<int>() > 0;
        return false;
    };
    one.send(t.daemon.port("ground"), Bytes(telemetry.begin(), telemetry.begin() + 7));
    t.daemon.run_for(60ms);
    two.send(t.daemon.port("ground"), Bytes(telemetry.begin(), telemetry.begin() + 7));
    ASSERT_TRUE(t.daemon.until([&] { return expired(one) || expired(two); }));
    EXPECT_TRUE(expired(one));
    EXPECT_TRUE(t.daemon.until([&] { return expired(two); })) << "nobody sends anything more";
}

TEST(UdpListenLink, a_peer_that_sends_is_kept) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().peer_timeout = 400ms;
    RunningGateway daemon{link};
    UdpPeer host, silent;
    silent.send(daemon.port("ground"), vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 1; }));
    ASSERT_TRUE(daemon.until([&] {
        host.send(daemon.port("ground"), vendor::who_are_you);
        daemon.run_for(10ms);
        return peers(daemon) == 1 && daemon.link("ground").at("channels").at(0).at("peer") == host.local().text();
    }));
}

TEST(UdpListenLink, a_host_that_only_listens_stays_registered) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().peer_timeout = 200ms;
    RunningGateway daemon{link, udp_listen("air")};
    UdpPeer host, device, air;
    host.send(daemon.port("ground"), vendor::who_are_you);
    device.send(daemon.port("ground"), vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 2; }));
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 1; })) << "the device was silent for too long";
    host.forget();
    air.send(daemon.port("air"), telemetry);
    EXPECT_TRUE(daemon.until([&] { return host.heard() == telemetry; }));
    EXPECT_FALSE(daemon.route("0xFE").is_null());
}

// Without the new peer, the next check would be an hour later.
TEST(UdpListenLink, a_device_that_joins_after_a_silent_host_expires_after_its_timeout) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().peer_timeout = 200ms;
    RunningGateway daemon{link};
    UdpPeer host, device, later;
    host.send(daemon.port("ground"), vendor::who_are_you);
    device.send(daemon.port("ground"), vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 2; }));
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 1; })) << "the device was silent for too long";
    later.send(daemon.port("ground"), vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 2; }));
    EXPECT_TRUE(daemon.until([&] { return peers(daemon) == 1; }));
    EXPECT_EQ(daemon.link("ground").at("channels").at(0).at("peer"), host.local().text());
}

TEST(UdpListenLink, keeps_the_two_most_recent_of_the_silent_hosts_of_one_address) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().peer_timeout = 200ms;
    RunningGateway daemon{link};
    UdpPeer hosts[4];
    for (UdpPeer& host : hosts) {
        const auto before = daemon.count("ground", "frames_in");
        host.send(daemon.port("ground"), vendor::who_are_you);
        ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == before + 1; }));
    }
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 2; }));
    const auto channels = daemon.link("ground").at("channels");
    for (const auto& channel : channels)
        EXPECT_TRUE(channel.at("peer") == hosts[2].local().text() || channel.at("peer") == hosts[3].local().text());
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(UdpListenLink, removes_the_peer_silent_for_longest_when_max_peers_is_reached) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().max_peers = 2;
    RunningGateway daemon{link};
    UdpPeer first, second, third;
    const auto send = [&](UdpPeer& peer) {
        const auto before = daemon.count("ground", "frames_in");
        peer.send(daemon.port("ground"), vendor::who_are_you);
        return daemon.until([&] { return daemon.count("ground", "frames_in") == before + 1; });
    };
    ASSERT_TRUE(send(first) && send(second) && send(first) && send(third));
    const auto channels = daemon.link("ground").at("channels");
    ASSERT_EQ(channels.size(), 2u);
    for (const auto& channel : channels) EXPECT_NE(channel.at("peer"), second.local().text());
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(UdpListenLink, a_sender_outside_the_allowed_networks_is_refused_and_counted) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().allow = {*anogate::Network::parse("10.0.0.0/8")};
    RunningGateway daemon{link};
    UdpPeer host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    host.send(daemon.port("ground"), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return daemon.count("ground", "denied_in") == 2; }));
    EXPECT_EQ(peers(daemon), 0u);
    EXPECT_EQ(daemon.count("ground", "frames_in"), 0u);
    EXPECT_NE(daemon.link("ground").at("hint").get<std::string>().find("allow"), std::string::npos);
}

TEST(UdpListenLink, accepts_senders_from_an_allowed_network_or_from_any) {
    auto one = udp_listen("one");
    one.as<anogate::UdpListenSettings>().allow = {*anogate::Network::parse("10.0.0.0/8"), *anogate::Network::parse("127.0.0.1")};
    auto any = udp_listen("any");
    any.as<anogate::UdpListenSettings>().allow_any = true;
    RunningGateway daemon{one, any, udp_listen("own")};
    UdpPeer host;
    for (const char* name : {"one", "any", "own"}) {
        host.send(daemon.port(name), vendor::who_are_you);
        EXPECT_TRUE(daemon.until([&] { return peers(daemon, name) == 1; })) << name;
    }
}

TEST(UdpListenLink, forwards_all_sixty_frames_of_one_datagram) {
    TwoLinks t;
    UdpPeer host;
    host.send(t.daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(t.daemon.until([&] { return peers(t.daemon) == 1; }));
    Bytes sixty;
    for (std::uint8_t n = 0; n < 60; ++n) sixty = sixty + frame(0xDC, 0xFE, 0xF1, Bytes(13, n));
    t.send(sixty);
    EXPECT_TRUE(t.daemon.until([&] { return host.heard() == sixty; }));
    EXPECT_EQ(t.daemon.count("air", "frames_in"), 60u);
}

TEST(UdpListenLink, forwards_all_frames_of_the_first_datagram_of_a_new_sender) {
    TwoLinks t;
    UdpPeer host;
    host.send(t.daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(t.daemon.until([&] { return peers(t.daemon) == 1; }));
    t.send(Bytes(5, 0x42) + telemetry + vendor::i_am_an_mcu);
    EXPECT_TRUE(t.daemon.until([&] { return host.heard() == vendor::i_am_an_mcu + telemetry; })) << "urgent first";
}

TEST(UdpListenLink, registers_a_sender_whose_first_frame_follows_a_false_header) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().max_peers = 2;
    RunningGateway daemon{link};
    UdpPeer first, second, odd;
    first.send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 1; }));
    odd.send(daemon.port("ground"), hex("AB 01 02 03 FF 00") + vendor::who_are_you);
    second.send(daemon.port("ground"), vendor::who_are_you);    // the one silent longest is `first`, not `odd`
    ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == 3; }));
    const auto channels = daemon.link("ground").at("channels");
    ASSERT_EQ(channels.size(), 2u);
    for (const auto& channel : channels) EXPECT_NE(channel.at("peer"), first.local().text());
}

TEST(UdpListenLink, a_frame_may_be_split_across_two_datagrams) {
    TwoLinks t;
    UdpPeer host;
    host.send(t.daemon.port("ground"), vendor::who_are_you);
    t.send(telemetry);
    ASSERT_TRUE(t.daemon.until([&] { return host.heard() == telemetry; }));
    t.send(Bytes(telemetry.begin(), telemetry.begin() + 7));
    t.send(Bytes(telemetry.begin() + 7, telemetry.end()));
    EXPECT_TRUE(t.daemon.until([&] { return host.heard() == telemetry + telemetry; }));
    EXPECT_EQ(t.daemon.count("air", "skipped_bytes"), 0u);
}

TEST(UdpListenLink, frames_after_a_false_header_of_one_peer_do_not_wait_for_other_peers) {
    RunningGateway daemon{udp_listen("ground")};
    UdpPeer first, second;
    for (UdpPeer* peer : {&first, &second}) peer->send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 2 && daemon.count("ground", "frames_in") == 2; }));
    const Bytes false_header = hex("AB 01 02 03 FF 00");
    first.send(daemon.port("ground"), false_header + telemetry);
    // While it sends, the second has no quiet moment.
    auto again = std::chrono::steady_clock::now();
    EXPECT_TRUE(daemon.until([&] {
        if (const auto now = std::chrono::steady_clock::now(); now >= again) {
            again = now + 20ms;
            second.send(daemon.port("ground"), false_header);
        }
        return daemon.count("ground", "frames_in") == 3;
    }));
}

TEST(UdpListenLink, half_a_frame_does_not_spoil_the_next_datagram) {
    TwoLinks t;
    UdpPeer host;
    host.send(t.daemon.port("ground"), vendor::who_are_you);
    t.send(telemetry);
    ASSERT_TRUE(t.daemon.until([&] { return host.heard() == telemetry; }));
    t.send(Bytes(telemetry.begin(), telemetry.begin() + 7));
    t.send(vendor::i_am_an_mcu);
    EXPECT_TRUE(t.daemon.until([&] { return host.heard() == telemetry + vendor::i_am_an_mcu; }));
}

TEST(UdpListenLink, forwards_the_largest_possible_datagram) {
    auto ground = udp_listen("ground"), air = udp_listen("air");
    ground.max_data = air.max_data = 65535;
    ground.queue = air.queue = 128 * 1024;
    RunningGateway daemon{ground, air};
    UdpPeer host, camera;
    host.send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon) == 1; }));
    const Bytes image = frame(0xDF, 0xFE, 0xB0, Bytes(65507 - 8, 0xAB));
    ASSERT_TRUE(camera.send(daemon.port("air"), image));
    EXPECT_TRUE(daemon.until([&] { return !host.heard().empty(); }));
    EXPECT_TRUE(host.heard() == image);
}

TEST(UdpListenLink, counts_a_frame_too_large_for_any_datagram_and_sends_the_next_one) {
    // Two datagrams register a peer; no datagram can remove it.
    auto ground = udp_listen("ground"), air = udp_listen("air");
    ground.max_data = air.max_data = 65535;
    ground.queue = air.queue = 256 * 1024;
    RunningGateway daemon{ground, air};
    UdpPeer host, camera;
    host.send(daemon.port("ground"), vendor::who_are_you);
    camera.send(daemon.port("air"), telemetry);
    ASSERT_TRUE(daemon.until([&] { return host.heard() == telemetry; }));
    const Bytes image = frame(0xDF, 0xFE, 0xB0, Bytes(65535, 0x11));
    camera.send(daemon.port("air"), std::span{image}.first(40000));
    camera.send(daemon.port("air"), std::span{image}.subspan(40000));
    camera.send(daemon.port("air"), telemetry);
    EXPECT_TRUE(daemon.until([&] { return host.heard() == telemetry + telemetry; }));
    EXPECT_EQ(daemon.count("ground", "too_big"), 1u);
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(UdpListenLink, sends_and_receives_over_ipv6) {
    RunningGateway daemon{udp_listen("six", "[::1]:0"), udp_listen("air")};
    UdpPeer host{"[::1]:0"}, air;
    host.send(daemon.port("six"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon, "six") == 1; }));
    EXPECT_EQ(daemon.link("six").at("channels").at(0).at("peer"), host.local().text());
    air.send(daemon.port("air"), vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return host.heard() == vendor::i_am_an_mcu; }));
}

TEST(UdpListenLink, the_ipv6_any_address_serves_ipv4_too) {
    RunningGateway daemon{udp_listen("both", "[::]:0"), udp_listen("air")};
    UdpPeer four, six{"[::1]:0"}, air;
    four.send(daemon.port("both"), vendor::who_are_you);
    six.send(daemon.port("both"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return peers(daemon, "both") == 2; }));
    EXPECT_EQ(daemon.link("both").at("channels").at(0).at("peer"), four.local().text()) << "as people write it";
    four.forget();
    six.forget();
    air.send(daemon.port("air"), vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return four.heard() == vendor::i_am_an_mcu && six.heard() == vendor::i_am_an_mcu; }));
}

TEST(UdpListenLink, waits_for_a_port_in_use_and_opens_it_when_it_is_free) {
    auto holder = std::make_unique<UdpPeer>();
    const auto port = holder->port();
    RunningGateway daemon{udp_listen("ground", "127.0.0.1:" + std::to_string(port))};
    EXPECT_EQ(daemon.link("ground").at("state"), "waiting");
    EXPECT_EQ(daemon.link("ground").at("error"), "port " + std::to_string(port) + " is in use by another program");
    holder.reset();
    ASSERT_TRUE(daemon.until_up("ground"));
    UdpPeer host;
    host.send(port, vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return peers(daemon) == 1; }));
}

/// `interface` may be empty.
anogate::LinkSettings port_of(const std::string& name, const std::string& local, const std::string& interface) {
    auto link = udp_listen(name, local);
    link.as<anogate::UdpListenSettings>().interface = interface;
    return link;
}

TEST(UdpListenLink, of_an_interface_ignores_its_addresses_on_another_interface) {
    ANOGATE_NEEDS_NAMESPACES();
    OpenNetworkBeside t;
    const auto ground = t.at(t.ground), stranger = t.at(t.stranger);
    const Inside inside{t.vehicle};
    for (const bool bound : {false, true}) {
        const auto daemon = t.gateway({port_of("ground", "10.77.0.1:12333", bound ? "wg0" : "")});
        OpenNetworkBeside::expect_heard(*daemon, *ground, *stranger, "10.77.0.1:12333", bound);
        EXPECT_EQ(peers(*daemon), bound ? 1u : 2u);
        EXPECT_EQ(daemon->link("ground").at("kernel_drops"), 0);
    }
}

TEST(UdpListenLink, of_an_interface_waits_for_it_and_uses_the_next_one_with_that_name) {
    ANOGATE_NEEDS_NAMESPACES();
    OpenNetworkBeside t;
    const auto daemon = t.gateway({port_of("ground", "10.77.0.1:12333", "wg0")});
    t.expect_ground_to_follow(*daemon);
    const Inside inside{t.vehicle};
    const auto ground = t.at(t.ground);
    ground->send(endpoint("10.77.0.1:12333"), vendor::who_are_you);
    EXPECT_TRUE(daemon->until([&] { return peers(*daemon) == 1; }));
}

TEST(UdpListenLink, one_link_of_each_interface_can_use_the_same_port) {
    ANOGATE_NEEDS_NAMESPACES();
    OpenNetworkBeside t;
    const auto ground = t.at(t.ground), stranger = t.at(t.stranger);
    const auto daemon = t.gateway({port_of("private", "0.0.0.0:12333", "wg0"), port_of("open", "0.0.0.0:12333", "wifi0"),
                                   port_of("both", "0.0.0.0:12333", ""), port_of("again", "0.0.0.0:12333", "wg0")});
    const Inside inside{t.vehicle};
    ASSERT_TRUE(daemon->until_up("private") && daemon->until_up("open"));
    for (const char* third : {"both", "again"})
        EXPECT_EQ(daemon->link(third).at("error"), "port 12333 is in use by another program");
    ground->send(endpoint("10.77.0.1:12333"), vendor::who_are_you);
    for (int i = 0; i < 2; ++i) stranger->send(endpoint("192.168.7.1:12333"), vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("private", "frames_in") + daemon->count("open", "frames_in") == 3; }));
    EXPECT_EQ(daemon->count("private", "frames_in"), 1u);
    EXPECT_EQ(daemon->count("open", "frames_in"), 2u);
}

TEST(UdpListenLink, a_lost_peer_does_not_disturb_other_peers) {
    TwoLinks t;
    auto gone = std::make_unique<UdpPeer>();
    UdpPeer host;
    gone->send(t.daemon.port("ground"), vendor::who_are_you);
    host.send(t.daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(t.daemon.until([&] { return peers(t.daemon) == 2; }));
    host.forget();
    gone.reset();
    Bytes expected;
    for (int i = 0; i < 20; ++i) {
        t.send(telemetry);
        expected = expected + telemetry;
        ASSERT_TRUE(t.daemon.until([&] { return host.heard() == expected; }));
    }
    EXPECT_EQ(t.daemon.link("ground").at("state"), "up");
    EXPECT_TRUE(t.daemon.counters_add_up());
}

// Loopback answers at once: the error for a datagram to a closed port is returned by the next call.
TEST(UdpListenLink, network_errors_of_lost_peers_lose_no_frame_of_another_peer) {
    TwoLinks t;
    UdpPeer host;
    std::vector<std::unique_ptr<UdpPeer>> dead;
    for (int i = 0; i < 7; ++i)
        dead.emplace_back(std::make_unique<UdpPeer>())->send(t.daemon.port("ground"), vendor::who_are_you);
    host.send(t.daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(t.daemon.until([&] { return peers(t.daemon) == 8; }));
    host.forget();
    dead.clear();
    Bytes burst;
    for (std::uint8_t n = 0; n < 20; ++n) burst = burst + frame(0xDC, 0xFE, 0xF1, Bytes(13, n));
    Bytes expected;
    for (int i = 0; i < 20; ++i) {
        t.send(burst);
        expected = expected + burst;
        ASSERT_TRUE(t.daemon.until([&] { return host.heard() == expected; })) << i;
    }
    EXPECT_EQ(t.daemon.count("ground", "send_failed"), 0u);
    EXPECT_EQ(t.daemon.link("ground").at("state"), "up");
    EXPECT_TRUE(t.daemon.counters_add_up());
}

// The only wait by the clock in this file: a program has five seconds to restart on its port.
TEST(UdpListenLink, removes_a_listening_host_after_its_port_was_reported_closed_for_five_seconds) {
    RunningGateway daemon{udp_listen("four"), udp_listen("six", "[::1]:0"), udp_listen("both", "[::]:0"), udp_listen("air")};
    UdpPeer air, host4, host6{"[::1]:0"}, host_both;
    const std::pair<const char*, UdpPeer*> listening[] = {{"four", &host4}, {"six", &host6}, {"both", &host_both}};
    for (const auto& each : listening) {
        const std::string link = each.first;
        UdpPeer closed{link == "six" ? "[::1]:0" : "127.0.0.1:0"};
        for (int i = 0; i < 2; ++i) closed.send(daemon.port(link), vendor::who_are_you);    // one datagram might be forged
        each.second->send(daemon.port(link), vendor::who_are_you);
        ASSERT_TRUE(daemon.until([&] { return peers(daemon, link) == 2 && daemon.count(link, "frames_in") == 3; }));
    }
    const auto began = anogate::Clock::now();
    ASSERT_TRUE(daemon.until([&] {
        air.send(daemon.port("air"), telemetry);
        daemon.run_for(50ms);
        return peers(daemon, "four") == 1 && peers(daemon, "six") == 1 && peers(daemon, "both") == 1;
    }));
    EXPECT_GE(anogate::Clock::now() - began, 4s) << "the last of them was closed a moment before";
    for (const auto& [link, host] : listening)
        EXPECT_EQ(daemon.link(link).at("channels").at(0).at("peer"), host->local().text()) << link;
}

// Then every refusal is reported while alarms are handled.
TEST(UdpListenLink, removes_hosts_with_closed_ports_also_when_a_timer_sends) {
    const support::TempDir folder;
    support::Daemon gateway{ANOGATED, (folder.path() / "socket").string(), {"sim:fc", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(gateway.until_up("ground"));
    for (std::size_t i = 0; i < 2; ++i) {
        UdpPeer closed;
        closed.send(gateway.port("ground"), vendor::who_are_you);
        ASSERT_TRUE(gateway.until([&](const nlohmann::json&) { return gateway.count("ground", "frames_in") > i; }));
    }
    EXPECT_TRUE(gateway.until([&](const nlohmann::json&) { return gateway.link("ground").at("channels").empty(); }));
}

TEST(UdpListenLink, works_despite_thousands_of_unknown_senders) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().max_peers = 4;
    RunningGateway daemon{link};
    UdpPeer steady;
    const auto port = daemon.port("ground");
    steady.send(port, vendor::who_are_you);
    for (int i = 0; i < 5000; ++i) {
        UdpPeer{}.send(port, vendor::who_are_you);
        if (i % 16 == 0) daemon.io().poll();
    }
    steady.send(port, vendor::who_are_you);
    // The kernel gives some ports a second time: if that is a second later, the program counts as one that sent again, and stays.
    EXPECT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") + daemon.count("ground", "denied_in") > 4750; }));
    EXPECT_EQ(peers(daemon), 3u) << "one place is kept for a host that sends commands";
    EXPECT_TRUE(daemon.counters_add_up());
}

}    // namespace
}    // namespace udp_listen_tests
