// Strangers that connect to a listening TCP port: they use up neither the places of the link nor the channels of the gateway.
#include <support/namespaces.hpp>
#include <support/running_gateway.hpp>
#include <support/settings.hpp>
#include <support/tcp_peer.hpp>
#include <support/udp_peer.hpp>
#include <support/v7_vectors.hpp>
#include <support/vendor_frames.hpp>
#include <support/wait.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace tcp_places_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

class TcpStrangers : public testing::Test {
protected:
    void SetUp() override {
        ANOGATE_NEEDS_NAMESPACES();
        here = std::make_unique<Namespace>();
        there = std::make_unique<Namespace>();
        here->join(*there, "eth0", "10.0.0.1/24", "10.0.0.2/24");
        for (int i = 10; i < 60; ++i) there->ip("address add 10.0.0." + std::to_string(i) + "/24 dev eth0");
        here->ip("address add fd00::1/64 dev eth0 nodad");
        for (int i = 10; i < 30; ++i) there->ip("address add fd00::" + std::to_string(i) + "/64 dev eth0 nodad");
    }
    void TearDown() override {
        if (!daemon) return;
        const Inside inside{*here};
        daemon.reset();
    }
    void start(std::vector<std::string> links) {
        const Inside inside{*here};
        daemon = std::make_unique<RunningGateway>(settings_of_texts(std::move(links)));
    }
    bool until(const std::function<bool()>& holds) {
        return wait_until(holds, patience, [&] {
            const Inside inside{*here};
            daemon->io().restart();
            daemon->io().poll();
            daemon->io().run_one_for(200us);
        });
    }
    void run_for(std::chrono::milliseconds time) {
        const auto end = std::chrono::steady_clock::now() + time;
        until([&] { return std::chrono::steady_clock::now() >= end; });
    }
    TcpPeer connect(const std::string& from, const std::string& to) {
        const bool v6 = from.front() == '[';
        const auto source = anogate::SocketAddress::of(*anogate::Endpoint::parse(from + ":0"), v6);
        const auto target = anogate::SocketAddress::of(*anogate::Endpoint::parse(to), v6);
        const Inside inside{*there};
        anogate::UniqueFd fd{::socket(source.get()->sa_family, SOCK_STREAM | SOCK_CLOEXEC, 0)};
        if (::bind(fd.get(), source.get(), source.size) != 0 || ::connect(fd.get(), target.get(), target.size) != 0)
            throw std::runtime_error{"can't connect from " + from};
        ::fcntl(fd.get(), F_SETFL, O_NONBLOCK);
        return TcpPeer{std::move(fd)};
    }
    TcpPeer connect(int from, const std::string& link) {
        return connect("10.0.0." + std::to_string(from), "10.0.0.1:" + std::to_string(daemon->port(link)));
    }
    /// Strangers from four addresses each, which send `bytes`.
    void connect_strangers(const std::string& link, int count, const Bytes& bytes, int first = 10) {
        for (int i = 0; i < count; ++i) {
            peers.push_back(connect(first + i / 4, link));
            if (!bytes.empty()) peers.back().send(bytes);
        }
    }
    std::size_t channels(const std::string& link) { return daemon->link(link).at("channels").size(); }
    /// Whether a UDP host gets through.
    bool is_answered(const std::string& from, const Bytes& frame) {
        std::unique_ptr<UdpPeer> host;
        {
            const Inside inside{*there};
            host = std::make_unique<UdpPeer>(from + ":0");
        }
        const auto before = daemon->count("ground", "bytes_in");
        host->send(anogate::Endpoint{anogate::IpAddress::v4(10, 0, 0, 1), daemon->port("ground")}, frame);
        until([&] { return daemon->count("ground", "bytes_in") > before; });
        return channels("ground") > 0;
    }

    const Bytes asks = vendor::who_are_you, commands = frame(0xFE, 0xDC, 0xC0, {16, 1, 0});
    std::unique_ptr<Namespace> here, there;
    std::unique_ptr<RunningGateway> daemon;
    std::vector<TcpPeer> peers;
};

TEST_F(TcpStrangers, that_send_nothing_use_at_most_half_of_the_channels) {
    start({"tcp-listen:10.0.0.1:0,name=air,max_peers=64", "udp-listen:0.0.0.0:0,name=ground"});
    connect_strangers("air", 80, {});
    ASSERT_TRUE(until([&] { return daemon->link("air").at("without_frame") == 48; }));
    EXPECT_EQ(channels("air"), 32u);
    EXPECT_TRUE(is_answered("10.0.0.2", asks));
}

TEST_F(TcpStrangers, that_hold_all_channels_leave_one_to_a_trusted_host_and_one_that_commands) {
    const std::string air = "tcp-listen:10.0.0.1:0,max_peers=64,max_per_address=5,name=";
    start({air + "air", air + "more", "udp-listen:0.0.0.0:0,trusted=10.0.0.2/32,name=ground"});
    connect_strangers("air", 48, asks);
    connect_strangers("more", 16, asks, 30);
    ASSERT_TRUE(until([&] { return channels("air") + channels("more") == 64; }));
    EXPECT_FALSE(is_answered("10.0.0.50", asks));
    EXPECT_EQ(daemon->link("ground").at("error_id"), "no_channel");
    EXPECT_TRUE(is_answered("10.0.0.2", asks));
    EXPECT_EQ(channels("air") + channels("more"), 63u);
    TcpPeer pilot = connect(51, "more");
    pilot.send(commands);
    EXPECT_TRUE(until([&] { return channels("air") + channels("more") == 63 && daemon->count("more", "frames_in") == 17; }));
    EXPECT_FALSE(pilot.is_closed());
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(TcpStrangers, that_sent_a_frame_leave_places_for_a_host_that_commands) {
    start({"tcp-listen:10.0.0.1:0,name=air"});
    connect_strangers("air", 16, asks);
    ASSERT_TRUE(until([&] { return daemon->count("air", "denied_in") == 4; }));
    EXPECT_EQ(channels("air"), 12u);
    EXPECT_EQ(daemon->link("air").at("error_id"), "no_place");
    TcpPeer pilot = connect(50, "air");
    pilot.send(commands);
    EXPECT_TRUE(until([&] { return channels("air") == 13; }));
}

TEST_F(TcpStrangers, that_sent_a_frame_leave_places_for_a_host_that_commands_beside_those_for_trusted_ones) {
    start({"tcp-listen:10.0.0.1:0,name=air,trusted=10.0.0.60/32"});
    connect_strangers("air", 16, asks);
    ASSERT_TRUE(until([&] { return daemon->count("air", "denied_in") == 4; }));
    TcpPeer pilot = connect(50, "air");
    pilot.send(commands);
    EXPECT_TRUE(until([&] { return channels("air") == 13 || daemon->count("air", "denied_in") > 4; }));
    EXPECT_EQ(channels("air"), 13u);
}

TEST_F(TcpStrangers, with_many_addresses_of_an_ipv6_network_count_as_one) {
    start({"tcp-listen:[fd00::1]:0,name=air"});
    const std::string to = "[fd00::1]:" + std::to_string(daemon->port("air"));
    for (int i = 0; i < 16; ++i) {
        peers.push_back(connect("[fd00::" + std::to_string(10 + i) + "]", to));
        peers.back().send(asks);
    }
    ASSERT_TRUE(until([&] { return daemon->count("air", "denied_in") == 13; }));
    EXPECT_EQ(channels("air"), 3u);
    TcpPeer pilot = connect("[fd00::29]", to);
    pilot.send(commands);
    EXPECT_TRUE(until([&] { return channels("air") == 4; }));
}

TEST_F(TcpStrangers, that_hold_all_places_for_silent_connections_are_replaced_by_a_host_that_commands) {
    start({"tcp-listen:10.0.0.1:0,name=air", "udp-listen:0.0.0.0:0,name=ground"});
    connect_strangers("air", 112, {});
    ASSERT_TRUE(until([&] { return daemon->link("air").at("without_frame") == 100; }));
    connect_strangers("air", 156, {});
    ASSERT_TRUE(until([&] { return daemon->link("air").at("without_frame") == 256; }));
    TcpPeer pilot = connect(50, "air");
    pilot.send(commands);
    EXPECT_TRUE(until([&] { return channels("air") == 13; }));
    EXPECT_EQ(std::count_if(peers.begin(), peers.end(), [](TcpPeer& p) { return p.is_closed(); }), 1);
}

TEST_F(TcpStrangers, that_leave_make_room_for_a_client_that_only_receives) {
    start({"tcp-listen:10.0.0.1:0,name=air,max_peers=1", "sim:fc,name=fc"});
    TcpPeer first = connect(10, "air");
    ASSERT_TRUE(until([&] { return channels("air") == 1; }));
    TcpPeer listener = connect(11, "air");
    ASSERT_TRUE(until([&] { return daemon->link("air").at("without_frame") == 1; }));
    EXPECT_TRUE(listener.heard().empty());
    first.close();
    EXPECT_TRUE(until([&] { return !listener.heard().empty(); }));
}

TEST_F(TcpStrangers, of_the_same_address_do_not_replace_a_quiet_host) {
    start({"tcp-listen:10.0.0.1:0,name=air"});
    connect_strangers("air", 4, commands);
    ASSERT_TRUE(until([&] { return daemon->count("air", "frames_in") == 4; }));
    run_for(1300ms);
    TcpPeer fifth = connect(10, "air");
    fifth.send(asks);
    ASSERT_TRUE(until([&] { return daemon->count("air", "denied_in") == 1; }));
    EXPECT_EQ(std::count_if(peers.begin(), peers.end(), [](TcpPeer& p) { return p.is_closed(); }), 0);
}

TEST_F(TcpStrangers, that_send_again_replace_no_trusted_host_beyond_the_reserved_places) {
    start({"tcp-listen:10.0.0.1:0,name=air,max_peers=4,trusted=10.0.0.40/29"});
    for (const int host : {40, 40, 41, 41}) {
        peers.push_back(connect(host, "air"));
        peers.back().send(commands);
    }
    ASSERT_TRUE(until([&] { return channels("air") == 4; }));
    TcpPeer stranger = connect(10, "air");
    const auto end = std::chrono::steady_clock::now() + 2500ms;
    while (std::chrono::steady_clock::now() < end) {
        stranger.send(asks);
        run_for(150ms);
    }
    EXPECT_EQ(std::count_if(peers.begin(), peers.end(), [](TcpPeer& p) { return p.is_closed(); }), 0);
    EXPECT_GT(daemon->count("air", "denied_in"), 1u);
}

TEST_F(TcpStrangers, do_not_keep_a_restarted_device_from_its_place) {
    start({"tcp-listen:10.0.0.1:0,name=air,max_peers=1"});
    const Bytes telemetry = frame(0xDC, 0xFE, 0x01, Bytes(13));
    TcpPeer before = connect(10, "air");
    before.send(telemetry);
    ASSERT_TRUE(until([&] { return channels("air") == 1; }));
    run_for(1100ms);    // it restarts without closing its connection
    TcpPeer stranger = connect(11, "air");
    stranger.send(telemetry);
    ASSERT_TRUE(until([&] { return daemon->count("air", "denied_in") == 1; }));
    TcpPeer after = connect(10, "air");
    after.send(telemetry);
    EXPECT_TRUE(until([&] { return before.is_closed(); }));
    EXPECT_FALSE(after.is_closed());
    EXPECT_EQ(channels("air"), 1u);
}

// Frames of V7 name no sender: the link knows it.
TEST_F(TcpStrangers, do_not_keep_a_restarted_v7_device_from_its_place) {
    start({"tcp-listen:10.0.0.1:0,name=air,max_peers=1,protocol=v7,v7_device=0xDD"});
    const Bytes attitude = v7_frame(0xFF, 0x03, {1, 0, 2, 0, 3, 0, 1});
    TcpPeer before = connect(10, "air");
    before.send(attitude);
    ASSERT_TRUE(until([&] { return daemon->count("air", "frames_in") == 1; }));
    run_for(1100ms);    // it restarts without closing its connection
    TcpPeer stranger = connect(11, "air");
    stranger.send(attitude);
    ASSERT_TRUE(until([&] { return daemon->count("air", "denied_in") == 1; }));
    TcpPeer after = connect(10, "air");
    after.send(attitude);
    EXPECT_TRUE(until([&] { return before.is_closed() || daemon->count("air", "denied_in") > 1; }));
    EXPECT_TRUE(before.is_closed());
    EXPECT_FALSE(after.is_closed());
    EXPECT_EQ(channels("air"), 1u);
}

TEST_F(TcpStrangers, that_hold_all_places_are_replaced_by_a_v7_host_program_that_commands) {
    start({"tcp-listen:10.0.0.1:0,name=air,protocol=v7,v7_role=host,v7_device=0xDC"});
    connect_strangers("air", 16, v7_frame(0xFF, 0xE1, {1, 0}));
    ASSERT_TRUE(until([&] { return daemon->count("air", "denied_in") == 4; }));
    TcpPeer pilot = connect(50, "air");
    pilot.send(v7_frame(0xFF, 0xE0, {16, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(until([&] { return channels("air") == 13 || daemon->count("air", "denied_in") > 4; }));
    EXPECT_EQ(channels("air"), 13u);
}

}    // namespace
}    // namespace tcp_places_tests
