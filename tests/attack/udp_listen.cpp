// Attacks on a listening UDP port with forged sources, new ports and closed ones, and their effect. tests/README.md has the
// figures.
#include <link/udp/udp_settings.hpp>
#include <support/namespaces.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <netinet/ip.h>
#include <netinet/udp.h>

#include <algorithm>
#include <cstdlib>
#include <new>

namespace {

std::size_t max_allocation = SIZE_MAX;    // larger allocations fail

}    // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
    void* memory = size > max_allocation ? nullptr : std::malloc(size > 0 ? size : 1);
    if (!memory) throw std::bad_alloc{};
    return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
void* operator new[](std::size_t size) { return operator new(size); }
void operator delete[](void* memory) noexcept { operator delete(memory); }
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
void operator delete[](void* memory, std::size_t) noexcept { operator delete(memory); }

namespace udp_listen_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Endpoint;

Bytes telemetry(std::uint8_t source, std::uint8_t n) { return frame(source, 0xFE, 0xF1, {n, 1, 2, 3, 4, 5, 6, 7, 8, 9}); }
Bytes command(std::uint8_t to, std::uint8_t n, std::uint8_t pilot = 0) { return frame(0xFE, to, 0xC0, {16, pilot, n}); }

/// One datagram in an IPv4 packet with any sender address, sent from the namespace of the thread.
void send_forged(const Endpoint& from, const Endpoint& to, const Bytes& datagram) {
    const anogate::UniqueFd raw{::socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC, IPPROTO_RAW)};
    ASSERT_TRUE(raw) << "forging needs root";
    iphdr ip{};
    ip.ihl = 5;
    ip.version = 4;
    ip.ttl = 64;
    ip.protocol = IPPROTO_UDP;
    std::memcpy(&ip.saddr, from.address.bytes.data(), 4);
    std::memcpy(&ip.daddr, to.address.bytes.data(), 4);
    udphdr udp{};
    udp.source = htons(from.port);
    udp.dest = htons(to.port);
    udp.len = htons(static_cast<std::uint16_t>(sizeof udp + datagram.size()));
    Bytes packet(sizeof ip + sizeof udp);
    std::memcpy(packet.data(), &ip, sizeof ip);
    std::memcpy(packet.data() + sizeof ip, &udp, sizeof udp);
    packet = packet + datagram;
    const auto address = anogate::SocketAddress::of({to.address, 0}, false);
    ASSERT_EQ(::sendto(raw.get(), packet.data(), packet.size(), 0, address.get(), address.size),
              static_cast<ssize_t>(packet.size()));
}

/// A gateway with its flight controller and its operator, in its own namespace.
class Vehicle {
public:
    Vehicle(const Namespace& space, const std::string& address, std::vector<anogate::LinkSettings> links)
        : space_{space}, address_{address} {
        const Inside inside{space_};
        links.push_back(udp_listen("air"));
        gateway_ = std::make_unique<RunningGateway>(settings_of(std::move(links)));
        fc_ = std::make_unique<UdpPeer>();
        pilot_ = std::make_unique<UdpPeer>();
    }
    ~Vehicle() {
        const Inside inside{space_};
        gateway_.reset();
    }
    Vehicle(const Vehicle&) = delete;
    Vehicle& operator=(const Vehicle&) = delete;

    RunningGateway& gateway() { return *gateway_; }
    UdpPeer& fc() { return *fc_; }
    UdpPeer& pilot() { return *pilot_; }
    Endpoint ground() { return {anogate::IpAddress::parse(address_).value(), gateway_->port("ground")}; }
    std::size_t peers(const std::string& link = "ground") { return gateway_->link(link).at("channels").size(); }
    std::string hint() { return gateway_->link("ground").at("hint"); }
    bool has_peer(const Endpoint& endpoint) {
        const auto link = gateway_->link("ground");
        for (const auto& channel : link.at("channels"))
            if (channel.at("peer") == endpoint.text()) return true;
        return false;
    }

    void send_from_fc(const Bytes& bytes) { fc_->send(gateway_->port("air"), bytes); }
    void send_from_pilot(const Bytes& bytes) { pilot_->send(gateway_->port("ground"), bytes); }
    /// Its loop runs in the namespace of its interfaces.
    void turn() {
        const Inside inside{space_};
        gateway_->io().restart();
        gateway_->io().poll();
        gateway_->io().run_one_for(200us);
    }
    /// How many frames of an id its flight controller has received; of commands, only those of one pilot.
    std::size_t carried_out(std::uint8_t id, std::uint8_t pilot = 0) {
        std::size_t count = 0;
        for (const Bytes& one : split(fc_->heard()).frames)
            if (one[3] == id && (id != 0xC0 || one[7] == pilot)) ++count;
        return count;
    }

private:
    const Namespace& space_;
    std::string address_;
    std::unique_ptr<RunningGateway> gateway_;
    std::unique_ptr<UdpPeer> fc_, pilot_;
};

class Attack : public testing::Test {
protected:
    void SetUp() override {
        ANOGATE_NEEDS_NAMESPACES();
        here = std::make_unique<Namespace>();
        there = std::make_unique<Namespace>();
        here->join(*there, "eth0", "10.0.0.1/24", "10.0.0.2/24");
    }
    std::unique_ptr<Namespace> here, there;
};

class TwoVehicles : public Attack {
protected:
    void start() {
        one = std::make_unique<Vehicle>(*here, "10.0.0.1", std::vector{udp_listen("ground", "0.0.0.0:0")});
        two = std::make_unique<Vehicle>(*there, "10.0.0.2", std::vector{udp_listen("ground", "0.0.0.0:0")});
        for (Vehicle* vehicle : {one.get(), two.get()}) {
            vehicle->send_from_fc(telemetry(vehicle == one.get() ? 0xDC : 0xDD, 0));
            vehicle->send_from_pilot(frame(0xFE, 0x30, 0xE0, {1, 0, 0}));
        }
        ASSERT_TRUE(
            until([&] { return one->peers("air") == 1 && two->peers("air") == 1 && one->peers() == 1 && two->peers() == 1; }));
    }
    void TearDown() override {
        one.reset();
        two.reset();
    }
    void turn() {
        one->turn();
        two->turn();
    }
    bool until(const std::function<bool()>& holds) {
        return wait_until(holds, patience, [this] { turn(); });
    }
    void settle() {
        for (int i = 0; i < 20; ++i) turn();
    }
    void forge_from_one(const Bytes& bytes) {
        const Inside inside{*here};
        send_forged(one->ground(), two->ground(), bytes);
    }
    void forge_from_two(const Bytes& bytes) {
        const Inside inside{*there};
        send_forged(two->ground(), one->ground(), bytes);
    }
    // The scenario of the figures: 79 commands of the first operator, while both vehicles send.
    void fly() {
        for (std::uint8_t n = 0; n < 79; ++n) {
            one->send_from_pilot(command(n % 2 == 0 ? 0xFF : 0xDD, n, 1));
            two->send_from_pilot(command(n % 2 == 0 ? 0xFF : 0xDC, n, 2));
            turn();
            one->send_from_fc(telemetry(0xDC, n));
            two->send_from_fc(telemetry(0xDD, n));
            turn();
        }
        settle();
    }
    void expect_apart() {
        EXPECT_EQ(two->peers(), 1u);
        EXPECT_EQ(one->peers(), 1u);
        for (Vehicle* vehicle : {one.get(), two.get()}) {
            const std::uint8_t own = vehicle == one.get() ? 1 : 2, other = own == 1 ? 2 : 1;
            EXPECT_EQ(vehicle->carried_out(0xC0, other), 0u);
            EXPECT_GE(vehicle->carried_out(0xC0, own), 75u) << "but for those to the other while it was taken for a peer";
            EXPECT_EQ(vehicle->carried_out(0xFB), 0u);
            EXPECT_GT(vehicle->gateway().count("ground", "denied_in"), 0u);
            EXPECT_NE(vehicle->hint().find("another gateway"), std::string::npos) << vehicle->hint();
            EXPECT_TRUE(vehicle->gateway().counters_add_up());
        }
    }

    std::unique_ptr<Vehicle> one, two;
};

TEST_F(TwoVehicles, are_not_joined_by_a_forged_frame_of_a_host) {
    start();
    forge_from_one(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    ASSERT_TRUE(until([&] { return two->has_peer(one->ground()); })) << "the attack is one";
    fly();
    expect_apart();
}

TEST_F(TwoVehicles, are_not_joined_by_a_forged_frame_of_a_device) {
    start();
    forge_from_one(telemetry(0x40, 1));
    fly();
    expect_apart();
}

TEST_F(TwoVehicles, are_not_joined_by_forged_frames_to_both) {
    start();
    forge_from_one(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    forge_from_two(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    fly();
    expect_apart();
}

TEST_F(TwoVehicles, are_not_joined_by_a_thousand_forged_frames) {
    start();
    for (int i = 0; i < 100; ++i) {
        for (int k = 0; k < 10; ++k) forge_from_one(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
        turn();
        if (i % 10 != 0) continue;
        one->send_from_pilot(command(0xFF, static_cast<std::uint8_t>(i), 1));
        two->send_from_pilot(command(0xFF, static_cast<std::uint8_t>(i), 2));
    }
    settle();
    EXPECT_EQ(one->carried_out(0xC0, 1), 10u);
    EXPECT_EQ(one->carried_out(0xC0, 2), 0u);
    EXPECT_EQ(two->carried_out(0xC0, 1), 0u);
    EXPECT_FALSE(two->has_peer(one->ground()));
    EXPECT_FALSE(one->has_peer(two->ground()));
}

// Their questions are answered, and use up nothing that a question of the other gateway needs.
TEST_F(TwoVehicles, are_not_joined_by_a_forged_frame_among_questions_of_strangers) {
    start();
    {
        const Inside inside{*there};
        for (std::uint16_t n = 0; n < 300; ++n)
            for (Vehicle* const vehicle : {one.get(), two.get()}) {
                const auto question = anogate::frame_of({anogate::ListeningNotice::Kind::question, n + 1u});
                send_forged({anogate::IpAddress::v4(10, 0, 0, 3), static_cast<std::uint16_t>(20000 + n)}, vehicle->ground(),
                            Bytes(question.begin(), question.end()));
                turn();
            }
    }
    forge_from_two(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    fly();
    EXPECT_EQ(one->carried_out(0xC0, 2), 0u);
    EXPECT_EQ(two->carried_out(0xC0, 1), 0u);
}

TEST_F(TwoVehicles, the_very_first_command_is_carried_out_only_by_the_vehicle_it_was_sent_to) {
    start();
    forge_from_one(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    ASSERT_TRUE(until([&] { return two->has_peer(one->ground()); }));
    two->send_from_pilot(command(0xFF, 1));
    ASSERT_TRUE(until([&] { return two->carried_out(0xC0) == 1; }));
    ASSERT_TRUE(until([&] { return !two->has_peer(one->ground()); }));
    settle();
    EXPECT_EQ(one->carried_out(0xC0), 0u);
    EXPECT_EQ(one->peers(), 1u);
}

// A sender that forges the question can't forge the answer: it does not see the number.
TEST_F(TwoVehicles, a_forged_notice_does_not_mark_another_sender_as_a_gateway) {
    start();
    UdpPeer* ground = nullptr;
    {
        const Inside inside{*here};
        ground = new UdpPeer{"10.0.0.1:0"};
        ground->send(two->ground(), frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    }
    const std::unique_ptr<UdpPeer> owner{ground};
    ASSERT_TRUE(until([&] { return two->has_peer(ground->local()); }));
    for (const auto kind : {anogate::ListeningNotice::Kind::question, anogate::ListeningNotice::Kind::answer}) {
        const auto notice = anogate::frame_of({kind, 12345});
        const Inside inside{*here};
        send_forged(ground->local(), two->ground(), Bytes(notice.begin(), notice.end()));
    }
    settle();
    EXPECT_TRUE(two->has_peer(ground->local()));
    ASSERT_TRUE(until([&] {
        const Inside inside{*here};
        ground->send(two->ground(), command(0xFF, 7));
        return two->carried_out(0xC0) > 0;
    })) << "heard again after a second";
}

// Questions of so many unknown senders that the time of the operator's last suspension is forgotten.
TEST_F(TwoVehicles, forged_requests_suspend_an_operator_for_one_second_in_sixty_despite_other_senders) {
    start();
    UdpPeer* pilot = nullptr;
    {
        const Inside inside{*here};
        pilot = new UdpPeer{"10.0.0.1:0"};
        pilot->send(two->ground(), command(0xFF, 200, 9));
    }
    const std::unique_ptr<UdpPeer> owner{pilot};
    ASSERT_TRUE(until([&] { return two->carried_out(0xC0, 9) == 1; }));
    const auto ask = [&](const Endpoint& in_the_name_of) {
        const auto notice = anogate::frame_of({anogate::ListeningNotice::Kind::question, 12345});
        const Inside inside{*here};
        send_forged(in_the_name_of, two->ground(), Bytes(notice.begin(), notice.end()));
    };
    const auto ask_and_command = [&](std::uint8_t n) {
        ask(pilot->local());
        const Inside inside{*here};
        pilot->send(two->ground(), command(0xFF, n, 9));
    };
    ask_and_command(0);
    ASSERT_TRUE(until([&] { return two->gateway().count("ground", "suspended") == 1; })) << "the attack is one";
    const auto suspended_at = std::chrono::steady_clock::now();
    EXPECT_NE(two->hint().find("forge"), std::string::npos) << two->hint();
    ASSERT_TRUE(until([&] { return std::chrono::steady_clock::now() >= suspended_at + 1100ms; }));
    // On a slow machine there are fewer rounds: after 60 s it may be suspended again.
    for (std::uint8_t n = 1; n <= 20 && std::chrono::steady_clock::now() < suspended_at + 40s; ++n) {
        for (std::uint8_t i = 0; i < 140; ++i) ask({anogate::IpAddress::v4(10, 0, 0, 100), static_cast<std::uint16_t>(1000 + i)});
        two->send_from_fc(telemetry(0xDD, n));    // a peer that sent once is forgotten after 10 s
        ask_and_command(n);
        ASSERT_TRUE(until([&] { return two->carried_out(0xC0, 9) == 1u + n; })) << int{n};
    }
    EXPECT_EQ(two->gateway().count("ground", "suspended"), 1u);
    EXPECT_TRUE(two->gateway().counters_add_up());
}

TEST_F(TwoVehicles, are_joined_on_purpose_with_a_udp_link) {
    two = std::make_unique<Vehicle>(*there, "10.0.0.2", std::vector{udp_listen("ground", "0.0.0.0:0")});
    one = std::make_unique<Vehicle>(*here, "10.0.0.1",
                                    std::vector{udp("join", two->ground().text()), udp_listen("ground", "0.0.0.0:0")});
    one->send_from_fc(telemetry(0xDC, 0));
    two->send_from_fc(telemetry(0xDD, 0));
    ASSERT_TRUE(until([&] { return two->peers() == 1 && one->peers("air") == 1; }));
    for (std::uint8_t n = 0; n < 79; ++n) {
        one->send_from_pilot(command(0xDD, n));
        turn();
        one->send_from_fc(telemetry(0xDC, n));
        two->send_from_fc(telemetry(0xDD, n));
        turn();
    }
    EXPECT_TRUE(until([&] { return two->carried_out(0xC0) == 79; })) << two->carried_out(0xC0);
    EXPECT_EQ(one->carried_out(0xFB), 0u);
    EXPECT_EQ(two->carried_out(0xFB), 0u);
    EXPECT_EQ(two->peers(), 1u);
}

TEST_F(Attack, a_socket_of_the_gateway_does_not_become_a_peer) {
    Vehicle vehicle{*here, "10.0.0.1", {udp_listen("ground", "0.0.0.0:0")}};
    const Endpoint air{anogate::IpAddress::v4(127, 0, 0, 1), vehicle.gateway().port("air")};
    const Endpoint ground{anogate::IpAddress::v4(127, 0, 0, 1), vehicle.gateway().port("ground")};
    {
        const Inside inside{*here};
        send_forged(ground, air, telemetry(0xDC, 1));
        send_forged(air, air, telemetry(0xDC, 1));
        send_forged(vehicle.ground(), air, telemetry(0xDC, 1));
    }
    ASSERT_TRUE(wait_until([&] { return vehicle.gateway().count("air", "denied_in") == 3; }, patience, [&] { vehicle.turn(); }));
    EXPECT_EQ(vehicle.peers("air"), 0u);
}

// 16 hosts on four addresses, and one address with a new port for every frame.
TEST_F(Attack, strangers_displace_no_peer) {
    for (int i = 0; i < 4; ++i) there->ip("address add 10.0.0.1" + std::to_string(i) + "/24 dev eth0");
    auto link = udp_listen("ground", "0.0.0.0:0");
    link.as<anogate::UdpListenSettings>().max_peers = 21;    // five of them are reserved for hosts that send commands
    Vehicle vehicle{*here, "10.0.0.1", {link}};
    const auto until = [&](const std::function<bool()>& holds) { return wait_until(holds, patience, [&] { vehicle.turn(); }); };
    std::vector<std::unique_ptr<UdpPeer>> hosts;
    const Inside inside{*there};
    for (int i = 0; i < 16; ++i) {
        hosts.push_back(std::make_unique<UdpPeer>("10.0.0.1" + std::to_string(i / 4) + ":0"));
        hosts.back()->send(vehicle.ground(), vendor::who_are_you);
    }
    ASSERT_TRUE(until([&] { return vehicle.peers() == 16; }));
    vehicle.send_from_fc(telemetry(0xDC, 0));
    ASSERT_TRUE(until([&] { return vehicle.peers("air") == 1; }));
    for (auto& host : hosts) host->forget();
    for (std::uint8_t n = 0; n < 50; ++n) {
        for (int i = 0; i < 20; ++i) UdpPeer{"10.0.0.2:0"}.send(vehicle.ground(), vendor::who_are_you);
        vehicle.send_from_fc(telemetry(0xDC, n));
        vehicle.turn();
    }
    ASSERT_TRUE(until([&] {
        return vehicle.gateway().count("ground", "denied_in") == 1000 && vehicle.gateway().count("air", "frames_in") == 51;
    }));
    std::size_t arrived = 0;
    for (auto& host : hosts)
        for (const Bytes& one : split(host->heard()).frames)
            if (one[3] == 0xF1) ++arrived;
    EXPECT_GE(arrived, 800u);
    EXPECT_EQ(vehicle.peers(), 16u);
    EXPECT_NE(vehicle.hint().find("max_per_address"), std::string::npos) << vehicle.hint();
    EXPECT_TRUE(vehicle.gateway().counters_add_up());
}

// The kernel keeps datagrams to a neighbour that does not answer for seconds, and they count against the send buffer of the socket.
TEST_F(Attack, a_peer_that_left_the_network_does_not_stop_what_is_sent_to_others) {
    there->ip("address add 10.0.0.3/24 dev eth0");
    const auto answers_are_awaited = [this](int probes) {
        here->ip("ntable change name arp_cache dev eth0 retrans 100 mcast_probes " + std::to_string(probes));
    };
    answers_are_awaited(1);
    auto link = udp_listen("ground", "0.0.0.0:0");
    link.pack = false;    // one frame per datagram
    Vehicle vehicle{*here, "10.0.0.1", {link}};
    const auto until = [&](const std::function<bool()>& holds) { return wait_until(holds, patience, [&] { vehicle.turn(); }); };
    std::unique_ptr<UdpPeer> stays, leaves;
    {
        const Inside inside{*there};
        stays = std::make_unique<UdpPeer>("10.0.0.2:0");
        leaves = std::make_unique<UdpPeer>("10.0.0.3:0");
    }
    for (UdpPeer* peer : {stays.get(), leaves.get()})
        for (int i = 0; i < 2; ++i) peer->send(vehicle.ground(), vendor::who_are_you);
    ASSERT_TRUE(until([&] { return vehicle.gateway().count("ground", "frames_in") == 4; }));
    there->ip("address del 10.0.0.3/24 dev eth0");
    here->ip("neigh flush to 10.0.0.3");
    std::uint8_t n = 0;
    const auto arrives = [&](int frames) {
        stays->forget();
        Bytes sent;
        for (; frames > 0; --frames) vehicle.send_from_fc(sent = telemetry(0xDC, ++n));
        return until([&] {
            const auto received = split(stays->heard()).frames;
            return std::find(received.begin(), received.end(), sent) != received.end();
        });
    };
    for (int i = 0; i < 100 && vehicle.gateway().count("ground", "send_failed") == 0; ++i) ASSERT_TRUE(arrives(1));
    ASSERT_TRUE(until([&] {
        vehicle.send_from_fc(telemetry(0xDC, ++n));
        return vehicle.gateway().count("ground", "send_failed") > 0;
    })) << "it is not reached";
    answers_are_awaited(6000);    // ten minutes
    for (int i = 0; i < 40; ++i) ASSERT_TRUE(arrives(10)) << i;
    EXPECT_EQ(vehicle.peers(), 2u);
    answers_are_awaited(1);
    there->ip("address add 10.0.0.3/24 dev eth0");
    leaves->send(vehicle.ground(), vendor::who_are_you);
    leaves->forget();
    EXPECT_TRUE(until([&] { return arrives(1) && split(leaves->heard()).frames.size() > 0; })) << "it is back";
    EXPECT_TRUE(vehicle.gateway().counters_add_up());
}

// It only receives, so it sends nothing that shows that it has returned. While it is absent it receives one frame per second.
TEST_F(Attack, a_peer_that_returns_to_the_network_receives_all_frames_from_the_third_on) {
    there->ip("address add 10.0.0.3/24 dev eth0");
    here->ip("ntable change name arp_cache dev eth0 retrans 100 mcast_probes 1");
    auto link = udp_listen("ground", "0.0.0.0:0");
    link.pack = false;
    Vehicle vehicle{*here, "10.0.0.1", {link}};
    const auto until = [&](const std::function<bool()>& holds) { return wait_until(holds, patience, [&] { vehicle.turn(); }); };
    std::unique_ptr<UdpPeer> listener;
    {
        const Inside inside{*there};
        listener = std::make_unique<UdpPeer>("10.0.0.3:0");
    }
    for (int i = 0; i < 2; ++i) listener->send(vehicle.ground(), vendor::who_are_you);
    ASSERT_TRUE(until([&] { return vehicle.gateway().count("ground", "frames_in") == 2; }));
    there->ip("address del 10.0.0.3/24 dev eth0");
    here->ip("neigh flush to 10.0.0.3");
    std::uint8_t n = 0;
    ASSERT_TRUE(until([&] {
        vehicle.send_from_fc(telemetry(0xDC, ++n));
        return vehicle.gateway().count("ground", "send_failed") > 20;
    }));
    there->ip("address add 10.0.0.3/24 dev eth0");
    listener->forget();
    unsigned tries = 0;
    Bytes sent;
    ASSERT_TRUE(until([&] {    // two frames in a row
        const auto received = split(listener->heard()).frames;
        const bool has_both = std::find(received.begin(), received.end(), sent) != received.end() &&
                              std::find(received.begin(), received.end(), telemetry(0xDC, static_cast<std::uint8_t>(n - 1))) !=
                                  received.end();
        tries = static_cast<unsigned>(received.size());
        if (!has_both) vehicle.send_from_fc(sent = telemetry(0xDC, ++n));
        return has_both;
    }));
    EXPECT_LE(tries, 5u) << "one per second until then";
    EXPECT_TRUE(vehicle.gateway().counters_add_up());
}

// The victim is outside the networks of the vehicle; the traffic that reaches it is the gain of the attack.
class Reflector : public Attack {
protected:
    void start(const std::vector<anogate::Network>& trusted = {}) {
        here->ip("route add default via 10.0.0.2");
        there->ip("address add 203.0.113.5/32 dev lo");
        auto link = udp_listen("ground", "0.0.0.0:0");
        link.as<anogate::UdpListenSettings>().allow_any = true;
        link.as<anogate::UdpListenSettings>().trusted = trusted;
        vehicle = std::make_unique<Vehicle>(*here, "10.0.0.1", std::vector{link});
        {
            const Inside inside{*there};
            victim = std::make_unique<UdpPeer>("203.0.113.5:0");
            send_forged(victim->local(), vehicle->ground(), frame(0xFE, 0xFF, 0x03, {}));
        }
        ASSERT_TRUE(until([&] { return vehicle->peers() == 1; }));
    }
    void TearDown() override { vehicle.reset(); }
    bool until(const std::function<bool()>& holds) {
        return wait_until(holds, patience, [&] { vehicle->turn(); });
    }
    void stream(int frames) {
        const auto before = vehicle->gateway().count("air", "frames_in");
        for (int n = 0; n < frames; ++n) {
            vehicle->send_from_fc(telemetry(0xDC, static_cast<std::uint8_t>(n)));
            vehicle->turn();
        }
        ASSERT_TRUE(
            until([&] { return vehicle->gateway().count("air", "frames_in") >= before + static_cast<std::uint64_t>(frames); }));
    }

    std::unique_ptr<Vehicle> vehicle;
    std::unique_ptr<UdpPeer> victim;
};

TEST_F(Reflector, eight_forged_bytes_cause_at_most_24_bytes_in_return) {
    start();
    stream(500);
    EXPECT_LE(victim->heard().size(), 24u);
    EXPECT_GT(vehicle->gateway().count("ground", "held_back"), 490u);
    EXPECT_NE(vehicle->hint().find("trusted"), std::string::npos) << vehicle->hint();
    EXPECT_TRUE(vehicle->gateway().counters_add_up());
}

TEST_F(Reflector, a_device_that_answers_the_requests_of_the_gateway_receives_all_frames) {
    start();
    int answers = 0;
    std::size_t read = 0;
    ASSERT_TRUE(until([&] {
        const auto frames = split(victim->heard()).frames;
        for (; read < frames.size(); ++read) {
            const Bytes& one = frames[read];
            if (one[3] != 0xE0) continue;
            ++answers;
            victim->send(vehicle->ground(), frame(0xDD, one[1], 0xE3, Bytes(15, 1)));
        }
        if (answers < 2) victim->send(vehicle->ground(), frame(0xDD, 0xFE, 0x03, Bytes(7, 0)));
        return answers == 2;
    }));
    ASSERT_TRUE(until([&] {
        vehicle->send_from_fc(telemetry(0xDC, 0));
        return split(victim->heard()).frames.size() > read + 20;
    }));
    victim->forget();
    stream(100);
    EXPECT_TRUE(until([&] { return split(victim->heard()).frames.size() >= 100; }));
    EXPECT_TRUE(vehicle->gateway().counters_add_up());
}

TEST_F(Reflector, a_peer_of_a_trusted_network_receives_all_frames_at_once) {
    start({*anogate::Network::parse("203.0.113.0/24")});
    stream(100);
    EXPECT_TRUE(until([&] { return split(victim->heard()).frames.size() >= 100; }));
    EXPECT_EQ(vehicle->gateway().count("ground", "held_back"), 0u);
}

TEST(ShortMemory, rejects_a_new_peer_and_keeps_serving_existing_ones) {
    RunningGateway daemon{udp_listen("ground"), udp_listen("air")};
    UdpPeer host, stranger, air;
    host.send(daemon.port("ground"), vendor::who_are_you);
    air.send(daemon.port("air"), telemetry(0xDC, 0));
    const auto peers = [&] { return daemon.link("ground").at("channels").size(); };
    ASSERT_TRUE(daemon.until([&] { return peers() == 1 && daemon.count("air", "frames_in") == 1; }));
    host.forget();
    max_allocation = 4096;
    stranger.send(daemon.port("ground"), vendor::who_are_you);
    const bool refused = wait_until([&] { return daemon.count("ground", "denied_in") == 1; }, patience,
                                    [&] {
                                        daemon.io().restart();
                                        daemon.io().poll();
                                    });
    max_allocation = SIZE_MAX;
    ASSERT_TRUE(refused);
    EXPECT_EQ(peers(), 1u);
    air.send(daemon.port("air"), telemetry(0xDC, 1));
    EXPECT_TRUE(daemon.until([&] { return host.heard() == telemetry(0xDC, 1); }));
    stranger.send(daemon.port("ground"), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return peers() == 2; })) << "memory is there again";
    EXPECT_TRUE(daemon.counters_add_up());
}

}    // namespace
}    // namespace udp_listen_tests
