// Which senders hold the places of peers, and which get one later. tests/README.md has the figures.
#include <gateway/peers/peer_book.hpp>
#include <link/udp/udp_settings.hpp>
#include <support/namespaces.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>
#include <support/v7_vectors.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <deque>
#include <memory>

namespace peer_places_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

Bytes command(std::uint8_t n) { return frame(0xFE, 0xDC, 0xC0, {16, 1, n}); }
std::size_t commands_in(const Bytes& bytes) {
    std::size_t count = 0;
    for (const Bytes& one : split(bytes).frames) count += one[3] == 0xC0 ? 1u : 0u;
    return count;
}

bool has_peer(RunningGateway& daemon, const std::string& link, const UdpPeer& peer) {
    const auto channels = daemon.link(link).at("channels");
    return std::any_of(channels.begin(), channels.end(), [&](const auto& c) { return c.at("peer") == peer.local().text(); });
}

class Strangers : public testing::Test {
protected:
    void SetUp() override {
        ANOGATE_NEEDS_NAMESPACES();
        here = std::make_unique<Namespace>();
        there = std::make_unique<Namespace>();
        here->join(*there, "eth0", "10.0.0.1/24", "10.0.0.2/24");
        for (int i = 10; i < 60; ++i) there->ip("address add 10.0.0." + std::to_string(i) + "/24 dev eth0");
    }
    void start(anogate::LinkSettings ground = udp_listen("ground", "0.0.0.0:0")) {
        const Inside inside{*here};
        daemon = std::make_unique<RunningGateway>(settings_of({std::move(ground), udp_listen("air")}));
        fc = std::make_unique<UdpPeer>();
        for (std::uint8_t n = 0; n < 2; ++n) send_from_fc(n);    // a peer that sent once is forgotten after 10 s
        ASSERT_TRUE(until([&] { return daemon->count("air", "frames_in") == 2; }));
        fc->forget();
    }
    void TearDown() override {
        if (!daemon) return;
        const Inside inside{*here};
        daemon.reset();
    }
    bool until(const std::function<bool()>& holds) {
        return wait_until(holds, patience, [&] {
            const Inside inside{*here};
            daemon->io().restart();
            daemon->io().poll();
            daemon->io().run_one_for(200us);
        });
    }
    void send_from_fc(std::uint8_t n) { fc->send(daemon->port("air"), frame(0xDC, 0xFE, 0xF1, Bytes(10, n))); }
    anogate::Endpoint to() const { return {anogate::IpAddress::v4(10, 0, 0, 1), daemon->port("ground")}; }
    UdpPeer& stranger(int address) {
        const Inside inside{*there};
        peers.push_back(std::make_unique<UdpPeer>("10.0.0." + std::to_string(address) + ":0"));
        return *peers.back();
    }
    std::size_t places() { return daemon->link("ground").at("channels").size(); }
    /// How many of seven commands of a host that joined late are carried out.
    std::size_t seven_commands(UdpPeer& pilot) {
        for (std::uint8_t n = 0; n < 7; ++n) {
            pilot.send(to(), command(n));
            const auto before = daemon->count("ground", "bytes_in");
            until([&] { return daemon->count("ground", "bytes_in") > before || commands_in(fc->heard()) > n; });
        }
        return commands_in(fc->heard());
    }

    std::unique_ptr<Namespace> here, there;
    std::unique_ptr<RunningGateway> daemon;
    std::unique_ptr<UdpPeer> fc;
    std::vector<std::unique_ptr<UdpPeer>> peers;
};

TEST_F(Strangers, that_only_listen_leave_quota_for_an_operator) {
    start();
    for (int i = 0; i < 16; ++i) stranger(10 + i).send(to(), vendor::who_are_you);
    ASSERT_TRUE(until([&] { return places() + daemon->count("ground", "denied_in") == 16; }));
    EXPECT_EQ(places(), 12u);
    EXPECT_EQ(seven_commands(stranger(40)), 7u);
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Strangers, that_only_ask_leave_quota_for_a_v7_host_program_that_commands) {
    auto link = udp_listen("ground", "0.0.0.0:0");
    auto& v7 = link.as<anogate::UdpListenSettings>().v7;
    v7.protocol = anogate::LinkProtocol::v7;
    v7.role = anogate::V7Role::host;
    v7.device = 0xDC;
    start(link);
    for (int i = 0; i < 16; ++i) stranger(10 + i).send(to(), v7_frame(0xFF, 0xE1, {1, 0}));
    ASSERT_TRUE(until([&] { return places() + daemon->count("ground", "denied_in") == 16; }));
    EXPECT_EQ(places(), 12u);
    fc->forget();
    stranger(40).send(to(), v7_frame(0xFF, 0xE0, {16, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(until([&] { return places() == 13 || daemon->count("ground", "denied_in") > 4; }));
    EXPECT_EQ(places(), 13u);
}

TEST_F(Strangers, that_send_unrequested_frames_leave_quota_for_an_operator) {
    start();
    for (int round = 0; round < 3; ++round)
        for (int i = 0; i < 16; ++i) {
            if (round == 0) stranger(10 + i);
            peers[static_cast<std::size_t>(i)]->send(
                to(), frame(static_cast<std::uint8_t>(30 + i), 0xFE, 0xF1, Bytes(10, static_cast<std::uint8_t>(round))));
        }
    ASSERT_TRUE(until([&] { return daemon->count("ground", "frames_in") + daemon->count("ground", "denied_in") == 48; }));
    EXPECT_EQ(seven_commands(stranger(40)), 7u);
}

TEST_F(Strangers, that_send_commands_leave_quota_for_a_trusted_network) {
    auto link = udp_listen("ground", "0.0.0.0:0");
    link.as<anogate::UdpListenSettings>().trusted = {*anogate::Network::parse("10.0.0.40/32")};
    start(link);
    for (int i = 0; i < 16; ++i) stranger(10 + i).send(to(), frame(0xFE, 0xDC, 0xC0, {16, 9, 0}));
    ASSERT_TRUE(until([&] { return daemon->count("ground", "bytes_in") == 16 * command(0).size(); }));
    EXPECT_EQ(places(), 14u);
    fc->forget();
    EXPECT_EQ(seven_commands(stranger(40)), 7u);
}

// As with forged sources, or computers behind one router.
TEST_F(Strangers, with_the_address_of_an_operator_block_none_of_its_commands) {
    for (const bool is_trusted : {false, true}) {
        auto link = udp_listen("ground", "0.0.0.0:0");
        if (is_trusted) link.as<anogate::UdpListenSettings>().trusted = {*anogate::Network::parse("10.0.0.40/32")};
        start(link);
        for (int i = 0; i < 4; ++i) stranger(40).send(to(), vendor::who_are_you);
        ASSERT_TRUE(until([&] { return places() == 3 && daemon->count("ground", "denied_in") == 1; }));
        std::this_thread::sleep_for(anogate::PeerBook::exchange);
        for (const auto& peer : peers) peer->send(to(), vendor::who_are_you);
        ASSERT_TRUE(until([&] { return daemon->count("ground", "frames_in") + daemon->count("ground", "denied_in") == 8; }));
        fc->forget();
        EXPECT_EQ(seven_commands(stranger(40)), 7u) << is_trusted;
        EXPECT_EQ(places(), 4u);
        EXPECT_TRUE(daemon->counters_add_up());
        peers.clear();
        TearDown();
    }
}

TEST_F(Strangers, that_send_commands_never_keep_trusted_operators_from_their_places) {
    auto link = udp_listen("ground", "0.0.0.0:0");
    link.as<anogate::UdpListenSettings>().trusted = {*anogate::Network::parse("10.0.0.40/29")};
    start(link);
    for (int i = 0; i < 16; ++i) stranger(10 + i).send(to(), frame(0xFE, 0xDC, 0xC0, {16, 9, 0}));
    ASSERT_TRUE(until([&] { return daemon->count("ground", "bytes_in") == 16 * command(0).size(); }));
    for (int i = 0; i < 6; ++i) {
        fc->forget();
        EXPECT_EQ(seven_commands(stranger(40 + i)), 7u) << i;
    }
}

TEST_F(Strangers, that_send_commands_block_no_command_of_an_operator) {
    start();
    for (int i = 0; i < 30; ++i) stranger(10 + i);
    UdpPeer& pilot = stranger(40);
    const auto commands = [&] {
        std::size_t count = 0;
        for (const Bytes& one : split(fc->heard()).frames)
            for (std::uint8_t n = 0; n < 20; ++n) count += one == command(n) ? 1u : 0u;
        return count;
    };
    const auto sent_and_read = [&](auto&& send, std::size_t datagrams) {
        const auto before = daemon->count("ground", "bytes_in");
        send();
        return until([&] {
            fc->heard();    // before its buffer is full
            return daemon->count("ground", "bytes_in") >= before + datagrams * command(0).size();
        });
    };
    for (std::uint8_t n = 0; n < 20; ++n) {
        send_from_fc(n);
        ASSERT_TRUE(sent_and_read(
            [&] {
                for (std::size_t i = 0; i < 30; ++i) peers[i]->send(to(), frame(0xFE, 0xDC, 0xC0, {16, 9, 0}));
            },
            30));
        EXPECT_EQ(places(), 16u);
        std::this_thread::sleep_for(anogate::PeerBook::turn * anogate::PeerBook::turns_at_once);
        ASSERT_TRUE(sent_and_read([&] { pilot.send(to(), command(n)); }, 1));
    }
    EXPECT_TRUE(until([&] { return commands() == 20; })) << commands();
    EXPECT_TRUE(daemon->counters_add_up());
}

// Reading comes first: its command waits behind much traffic of others when a new host gets its place.
TEST_F(Strangers, that_displace_an_operator_do_not_drop_its_command_that_is_waiting) {
    start();
    UdpPeer& talker = stranger(10);
    talker.send(to(), frame(0x40, 0xFF, 0xF1, Bytes(13, 1)));
    for (int i = 11; i < 25; ++i) stranger(i).send(to(), frame(0xFE, 0xDC, 0xC0, {16, 9, 0}));
    ASSERT_TRUE(until([&] { return places() == 15; }));
    UdpPeer& pilot = stranger(40);
    const auto arrived = [&](std::uint8_t n) {
        const auto frames = split(fc->heard()).frames;
        return std::find(frames.begin(), frames.end(), command(n)) != frames.end();
    };
    pilot.send(to(), command(0));
    ASSERT_TRUE(until([&] { return arrived(0); }));
    Bytes datagram;
    for (std::uint8_t n = 0; n < 60; ++n) datagram = datagram + frame(0x40, 0xFF, 0xF1, Bytes(13, n));
    for (int i = 0; i < 40; ++i) talker.send(to(), datagram);
    pilot.send(to(), command(1));
    for (int i = 50; i < 54; ++i) stranger(i).send(to(), frame(0xFE, 0xDC, 0xC0, {16, 9, 0}));
    ASSERT_TRUE(until([&] { return !has_peer(*daemon, "ground", pilot); })) << "the attack is one";
    EXPECT_TRUE(until([&] { return arrived(1); }));
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Strangers, that_send_once_from_many_addresses_keep_no_device_from_its_place) {
    start();
    UdpPeer& late = stranger(59);
    int strangers = 0;
    const auto send_once = [&] {    // its port stays open, as one that a forged source names
        stranger(10 + strangers++ % 49).send(to(), frame(0x40, 0xFE, 0xF1, Bytes(10, 1)));
    };
    const auto send_around = [&] {
        for (int i = 0; i < 5; ++i) send_once();
        late.send(to(), frame(0x41, 0xFE, 0xF1, Bytes(10, 2)));
        const auto before = daemon->count("ground", "bytes_in");
        until([&] { return daemon->count("ground", "bytes_in") > before; });
    };
    while (strangers < 16) send_once();
    ASSERT_TRUE(until([&] { return places() + daemon->count("ground", "denied_in") == 16; }));
    EXPECT_EQ(places(), 12u) << "the attack is one";
    ASSERT_TRUE(wait_until([&] { return send_around(), has_peer(*daemon, "ground", late); }, 9s,
                           [] { std::this_thread::sleep_for(50ms); }));
    late.forget();
    for (std::uint8_t n = 0; n < 20; ++n) {
        fc->send(daemon->port("air"), frame(0xFE, 0x41, 0xC0, {16, 1, n}));
        send_around();
    }
    EXPECT_TRUE(until([&] { return commands_in(late.heard()) == 20; })) << commands_in(late.heard());
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Strangers, with_one_forged_datagram_receive_telemetry_for_less_than_a_minute) {
    start();
    stranger(10).send(to(), frame(0x40, 0xFE, 0xF1, Bytes(10, 1)) + frame(0x40, 0xFE, 0xF1, Bytes(10, 2)));
    ASSERT_TRUE(until([&] { return places() == 1; }));
    const auto began = std::chrono::steady_clock::now();
    ASSERT_TRUE(wait_until([&] { return places() == 0; }, 15s,
                           [&] {
                               const Inside inside{*here};
                               daemon->io().restart();
                               daemon->io().run_one_for(100ms);
                           }));
    EXPECT_GE(std::chrono::steady_clock::now() - began, 9s);
}

TEST_F(Strangers, that_only_listen_are_shown_as_listening_and_removed_when_their_port_closes) {
    start();
    stranger(10).send(to(), vendor::who_are_you);
    ASSERT_TRUE(until([&] { return places() == 1; }));
    EXPECT_TRUE(daemon->link("ground").at("channels").at(0).contains("listening_since_s"));
    {
        const Inside inside{*there};
        peers.clear();
    }
    fc->send(daemon->port("air"), frame(0xDC, 0xFE, 0xF1, Bytes(10, 2)));
    ASSERT_TRUE(until([&] { return places() == 0; })) << "ICMP said that nothing listens there";
    stranger(10).send(to(), vendor::who_are_you);
    ASSERT_TRUE(until([&] { return places() == 1; }));
    peers.back()->send(to(), vendor::who_are_you);
    EXPECT_TRUE(until([&] { return !daemon->link("ground").at("channels").at(0).contains("listening_since_s"); }));
}

// From `by`: a datagram from the gateway's port `from` to `to` did not arrive, because its port is closed.
void report_closed_port(const char* by, const anogate::Endpoint& from, const anogate::Endpoint& to) {
    const anogate::UniqueFd socket{::socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC, IPPROTO_ICMP)};
    ASSERT_TRUE(socket);
    sockaddr_in address{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {}, .sin_zero = {}};
    ASSERT_EQ(::inet_pton(AF_INET, by, &address.sin_addr), 1);
    ASSERT_EQ(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const auto octets = [](const anogate::Endpoint& e) { return Bytes(e.address.bytes.begin(), e.address.bytes.begin() + 4); };
    const auto port = [](const anogate::Endpoint& e) {
        return Bytes{static_cast<std::uint8_t>(e.port >> 8), static_cast<std::uint8_t>(e.port & 0xFF)};
    };
    Bytes message = Bytes{3, 3, 0, 0, 0, 0, 0, 0} + Bytes{0x45, 0, 0, 28, 0, 0, 0, 0, 64, 17, 0, 0} + octets(from) + octets(to) +
                    port(from) + port(to) + Bytes{0, 8, 0, 0};
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < message.size(); i += 2) sum += std::uint32_t{message[i]} << 8 | message[i + 1];
    while (sum > 0xFFFF) sum = (sum & 0xFFFF) + (sum >> 16);
    message[2] = static_cast<std::uint8_t>(~sum >> 8);
    message[3] = static_cast<std::uint8_t>(~sum & 0xFF);
    ASSERT_EQ(::inet_pton(AF_INET, "10.0.0.1", &address.sin_addr), 1);
    EXPECT_EQ(
        ::sendto(socket.get(), message.data(), message.size(), 0, reinterpret_cast<const sockaddr*>(&address), sizeof address),
        static_cast<ssize_t>(message.size()));
}

TEST_F(Strangers, that_report_the_port_of_another_host_as_closed_remove_no_peer) {
    start();
    UdpPeer& listener = stranger(10);
    listener.send(to(), vendor::who_are_you);
    ASSERT_TRUE(until([&] { return places() == 1; }));
    std::uint8_t n = 0;
    const auto report = [&](const char* by) {
        const Inside inside{*there};
        report_closed_port(by, to(), listener.local());
    };
    const auto next_arrives = [&] {
        listener.forget();
        fc->send(daemon->port("air"), frame(0xDC, 0xFE, 0xF1, Bytes(10, ++n)));
        return until([&] { return !listener.heard().empty() || places() == 0; }) && places() == 1;
    };
    for (int i = 0; i < 20; ++i) {
        report("10.0.0.11");
        ASSERT_TRUE(next_arrives()) << i;
    }
    EXPECT_TRUE(until([&] {
        report("10.0.0.10");
        fc->send(daemon->port("air"), frame(0xDC, 0xFE, 0xF1, Bytes(10, ++n)));
        return places() == 0;
    })) << "its own host reports it";
}

TEST(LocalPeers, one_seen_once_does_not_replace_one_seen_again) {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().max_peers = 2;
    RunningGateway daemon{link};
    UdpPeer first, second;
    const auto send = [&](UdpPeer& peer) { peer.send(daemon.port("ground"), vendor::who_are_you); };
    send(first);
    send(second);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == 2; }));
    daemon.run_for(1s);
    send(first);
    send(second);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == 4; }));
    std::vector<std::unique_ptr<UdpPeer>> strangers;
    for (int i = 0; i < 20; ++i) {
        strangers.push_back(std::make_unique<UdpPeer>());
        send(*strangers.back());
    }
    ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "denied_in") == 20; }));
    std::vector<std::string> there;
    const auto ground = daemon.link("ground");
    for (const auto& channel : ground.at("channels")) there.push_back(channel.at("peer"));
    EXPECT_EQ(there, (std::vector{first.local().text(), second.local().text()}));
}

// 20 strangers between two frames of the device, each from another port.
TEST(LocalPeers, that_send_once_keep_no_device_from_its_place) {
    RunningGateway daemon{udp_listen("air"), udp_listen("ground")};
    UdpPeer station, device;
    std::deque<UdpPeer> strangers;    // open for a while: a closed port would be reported, and its place would become free
    const auto send_strangers = [&] {
        const auto before = daemon.count("air", "bytes_in");
        const Bytes once = frame(0x40, 0xFE, 0xF1, Bytes(10, 1));
        for (int i = 0; i < 20; ++i) strangers.emplace_back().send(daemon.port("air"), once);
        while (strangers.size() > 100) strangers.pop_front();
        EXPECT_TRUE(daemon.until([&] { return daemon.count("air", "bytes_in") >= before + 20 * once.size(); }));
    };
    const auto send = [&] { device.send(daemon.port("air"), frame(0x41, 0xFE, 0xF1, Bytes(10, 2))); };
    ASSERT_TRUE(wait_until(
        [&] {
            send();
            daemon.run_for(100ms);
            send_strangers();
            return has_peer(daemon, "air", device);
        },
        patience, [] {}));
    device.forget();
    for (std::uint8_t n = 0; n < 40; ++n) {
        send_strangers();
        station.send(daemon.port("ground"), frame(0xFE, 0x41, 0xC0, {16, 1, n}));
        EXPECT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == n + 1u; }));
        send();
    }
    EXPECT_TRUE(daemon.until([&] { return commands_in(device.heard()) == 40; })) << commands_in(device.heard());
    EXPECT_TRUE(daemon.counters_add_up());
}

}    // namespace
}    // namespace peer_places_tests
