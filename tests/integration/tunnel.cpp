// Two gateways in two network namespaces connected by a cable, a device on a pty at each.
#include <gateway/tunnel/tunnel.hpp>
#include <support/namespaces.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <memory>

namespace tunnel_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Deliver;
using anogate::IpAddress;
using anogate::Network;

constexpr std::uint8_t host = 0xFE, mcu = 0xDB, radio = 0xE6, everybody = 0xFF;
constexpr std::uint16_t port = 12333;

const Bytes ask_parameter = frame(host, mcu, 0xE0, {2, 4, 0});
const Bytes parameter = frame(mcu, host, 0xE1, {4, 0, 1, 2, 3, 4});
const Bytes command = frame(host, mcu, 0xC0, {0, 1, 2});
const Bytes telemetry = frame(mcu, everybody, 0x03, {1, 2, 3, 4, 5, 6, 7});

Bytes le16(std::uint16_t n) { return {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)}; }
Bytes ip4(const std::string& text) {
    const auto a = *IpAddress::parse(text);
    return {a.bytes.begin(), a.bytes.begin() + 4};
}
Bytes b1(const std::string& destination, std::uint16_t to_port, const Bytes& inner, const std::string& source = "0.0.0.0",
         std::uint8_t to = radio) {
    return frame(host, to, 0xB1, ip4(source) + ip4(destination) + le16(to_port) + inner);
}
Bytes b2(std::uint8_t destination, std::uint16_t to_port, const Bytes& inner, std::uint8_t source = 0) {
    return frame(host, radio, 0xB2, Bytes{source, destination} + le16(to_port) + inner);
}

// A gateway and its device.
struct Site {
    const Namespace space;
    const TempDir dir;
    PtyDevice device{dir / "fc"};
    anogate::Settings settings = settings_of({serial("fc", device.path())});
    std::unique_ptr<RunningGateway> gateway;
    std::size_t answered = 0;    // frames that the device has handled

    Site() { settings.tunnel.emplace().links = {"fc"}; }
    ~Site() { stop(); }
    anogate::TunnelSettings& tunnel() { return *settings.tunnel; }
    void start() {
        const Inside inside{space};
        gateway = std::make_unique<RunningGateway>(settings);
        ASSERT_TRUE(gateway->until_up("fc") && gateway->until_up("tunnel"));
    }
    void stop() {
        const Inside inside{space};
        gateway.reset();
    }
    void step() {
        const Inside inside{space};
        if (gateway) gateway->run_for(1ms);
    }
    /// The device is the MCU: it answers with its parameter and acknowledges writes.
    void answer() {
        const auto heard = split(device.heard()).frames;
        for (; answered < heard.size(); ++answered) {
            if (heard[answered] == ask_parameter) device.write(parameter);
            if (heard[answered] == vendor::write_parameter) device.write(vendor::written);
        }
    }
    std::uint64_t count(const std::string& name) {
        const Inside inside{space};
        return gateway->status().at("tunnel").at(name);
    }
    std::size_t peers() { return gateway->link("tunnel").at("channels").size(); }
    bool knows(const char* address, const char* link) {
        const auto route = gateway->route(address);
        return !route.is_null() && route.at("links") == nlohmann::json::array({link});
    }
    std::unique_ptr<UdpPeer> peer(const std::string& local) const {
        const Inside inside{space};
        return std::make_unique<UdpPeer>(local);
    }
};

class TwoGateways : public testing::Test {
protected:
    void SetUp() override {
        ANOGATE_NEEDS_NAMESPACES();
        a = std::make_unique<Site>();
        b = std::make_unique<Site>();
        a->space.join(b->space, "cable", "10.77.0.1/24", "10.77.0.2/24");
    }
    void start() {
        a->start();
        b->start();
    }
    bool until(const std::function<bool()>& holds) {
        return wait_until(holds, patience, [this] {
            a->step();
            b->step();
        });
    }
    /// Waits for a time; used only to show that something does not happen.
    void let_pass(anogate::Duration time) {
        for (const auto end = anogate::Clock::now() + time; anogate::Clock::now() < end;) {
            a->step();
            b->step();
        }
    }
    /// The device at `a` sends a request and a write inside tunnel frames; the answers return.
    void talk(const std::function<Bytes(const Bytes&)>& wrap) {
        a->device.write(wrap(ask_parameter));
        EXPECT_TRUE(until([&] {
            b->answer();
            return a->device.heard() == parameter;
        })) << "parameter request";
        a->device.write(wrap(vendor::write_parameter));
        EXPECT_TRUE(until([&] {
            b->answer();
            return a->device.heard() == parameter + vendor::written;
        })) << "acknowledged write";
        EXPECT_EQ(b->device.heard(), ask_parameter + vendor::write_parameter);
    }

    std::unique_ptr<Site> a, b;
};

struct Combination {
    const char* name;
    bool brief;
    Deliver deliver;
};

class Combinations : public TwoGateways, public testing::WithParamInterface<Combination> {
protected:
    static Bytes wrap(const Bytes& inner, std::uint16_t to_port = port) {
        return GetParam().brief ? b2(2, to_port, inner) : b1("10.77.0.2", to_port, inner);
    }
    void deliver_as_asked() { a->tunnel().deliver = GetParam().deliver; }
};

TEST_P(Combinations, a_request_and_an_acknowledged_write_pass_end_to_end) {
    deliver_as_asked();
    start();
    talk([](const Bytes& f) { return wrap(f); });
    EXPECT_EQ(a->count("out"), 2u);
    EXPECT_EQ(a->count("in"), 2u) << "the answers, plain";
    EXPECT_EQ(b->count("in"), 2u);
    EXPECT_EQ(b->count("unwrapped"), GetParam().deliver == Deliver::tunnel ? 2u : 0u);
    EXPECT_TRUE(b->knows("0xFE", "tunnel"));
    EXPECT_TRUE(a->knows("0xFE", "fc")) << "the source of what was inside";
    EXPECT_TRUE(a->gateway->counters_add_up() && b->gateway->counters_add_up());
}

TEST_P(Combinations, work_if_frames_to_unknown_addresses_are_dropped) {
    deliver_as_asked();
    a->settings.gateway.unknown = b->settings.gateway.unknown = anogate::Unknown::drop;
    start();
    b->device.write(telemetry);
    ASSERT_TRUE(until([&] { return b->knows("0xDB", "fc"); }));
    talk([](const Bytes& f) { return wrap(f); });
}

TEST_P(Combinations, port_0_is_the_tunnels_port) {
    deliver_as_asked();
    a->tunnel().port = b->tunnel().port = 23456;
    start();
    talk([](const Bytes& f) { return wrap(f, 0); });
}

TEST_P(Combinations, several_frames_inside_arrive_in_order) {
    deliver_as_asked();
    start();
    const Bytes several = command + ask_parameter + vendor::write_parameter;
    a->device.write(wrap(several));
    EXPECT_TRUE(until([&] { return b->device.heard() == several; }));
    EXPECT_EQ(a->count("out"), 1u) << "one datagram";
}

TEST_P(Combinations, a_truncated_frame_inside_is_counted_and_not_sent) {
    deliver_as_asked();
    start();
    const Bytes cut{command.begin(), command.end() - 3};
    a->device.write(wrap(cut));
    a->device.write(wrap(ask_parameter + cut));
    EXPECT_TRUE(until([&] { return b->device.heard() == ask_parameter; }));
    EXPECT_EQ(a->count("tunnel_bad_inner"), 2u);
    EXPECT_EQ(a->count("out"), 1u);
    EXPECT_EQ(b->count("tunnel_bad_inner"), 0u);
    EXPECT_EQ(b->gateway->count("tunnel", "skipped_bytes"), 0u);
}

INSTANTIATE_TEST_SUITE_P(TwoGateways, Combinations,
                         testing::Values(Combination{"B1_frames", false, Deliver::frames},
                                         Combination{"B1_tunnel", false, Deliver::tunnel},
                                         Combination{"B2_frames", true, Deliver::frames},
                                         Combination{"B2_tunnel", true, Deliver::tunnel}),
                         [](const auto& combination) { return std::string{combination.param.name}; });

TEST_F(TwoGateways, deliver_sets_the_format_of_datagrams) {
    const auto ground = b->peer("10.77.0.2:0");
    start();
    a->device.write(b1("10.77.0.2", ground->port(), command, "9.9.9.9"));
    EXPECT_TRUE(until([&] { return ground->heard() == command; }));
    EXPECT_EQ(ground->last_sender(), endpoint("10.77.0.1:12333"));

    a->stop();
    a->tunnel().deliver = Deliver::tunnel;
    a->start();
    ground->forget();
    a->device.write(b1("10.77.0.2", ground->port(), command, "9.9.9.9"));
    EXPECT_TRUE(until([&] { return ground->heard() == b1("10.77.0.2", ground->port(), command, "10.77.0.1"); }));
    ground->forget();
    a->device.write(b2(2, ground->port(), command, 99));
    EXPECT_TRUE(until([&] { return ground->heard() == b2(2, ground->port(), command, 1); }));
}

TEST_F(TwoGateways, the_short_form_is_sent_to_the_network_of_the_tunnel_ip) {
    a->space.join(b->space, "second", "10.78.0.1/24", "10.78.0.2/24");
    const auto first = b->peer("10.77.0.2:7000"), second = b->peer("10.78.0.2:7000");
    start();
    a->device.write(b2(2, 7000, command));
    EXPECT_TRUE(until([&] { return first->heard() == command; }));
    a->stop();
    a->tunnel().ip = IpAddress::parse("10.78.0.1");
    a->start();
    a->device.write(b2(2, 7000, command));
    EXPECT_TRUE(until([&] { return second->heard() == command; }));
    EXPECT_EQ(first->heard(), command) << "nothing more";
}

TEST_F(TwoGateways, the_short_form_from_a_sender_in_another_network_is_not_accepted) {
    a->space.ip("address add 10.79.1.1/16 dev cable");
    b->space.ip("address add 10.79.2.2/16 dev cable");
    start();
    const auto stranger = a->peer("10.79.1.1:0");
    stranger->send(endpoint("10.79.2.2:12333"), b2(2, 0, command, 1));
    EXPECT_TRUE(until([&] { return b->count("tunnel_other_ip") == 1; })) << "10.79.1.2 was meant";
    stranger->send(endpoint("10.79.2.2:12333"), b1("10.79.2.2", 0, command));
    EXPECT_TRUE(until([&] { return b->device.heard() == command; }));
}

// Repeated bytes cause a probe (0xFB) that detects a ring; connected gateways receive it.
Bytes but_probes(const Bytes& heard) {
    Bytes rest;
    for (const Bytes& one : split(heard).frames)
        if (one[3] != 0xFB) rest.insert(rest.end(), one.begin(), one.end());
    return rest;
}

TEST_F(TwoGateways, tunnel_frames_to_another_address_are_forwarded) {
    a->settings.gateway.id = 199;
    start();
    const auto listener = b->peer("10.77.0.2:0");
    listener->send(endpoint("10.77.0.1:12333"), frame(30, 31, 0x03, {1, 2, 3, 4, 5, 6, 7}));
    ASSERT_TRUE(until([&] { return a->knows("0x1E", "tunnel"); }));
    const Bytes for_another = b1("10.77.0.2", port, command, "0.0.0.0", 30);
    a->device.write(for_another);
    EXPECT_TRUE(until([&] { return listener->heard() == for_another; }));
    EXPECT_EQ(a->count("out"), 0u);
    for (const std::uint8_t to : {std::uint8_t{199}, radio, everybody})
        a->device.write(b1("10.77.0.2", port, command, "0.0.0.0", to));
    EXPECT_TRUE(until([&] { return a->count("out") == 3; }));
    let_pass(20ms);
    EXPECT_EQ(but_probes(listener->heard()), for_another) << "what the tunnel takes ends there, also what is for everybody";
}

TEST_F(TwoGateways, tunnel_frames_from_other_links_are_forwarded) {
    a->tunnel().links.clear();
    start();
    a->device.write(b1("10.77.0.2", port, command));
    EXPECT_TRUE(until([&] { return a->gateway->count("fc", "no_route") == 1; }));
    EXPECT_EQ(a->count("out"), 0u);
}

TEST_F(TwoGateways, a_peer_receives_broadcasts_and_a_tunnel_destination_does_not_become_a_peer) {
    start();
    const auto peer = b->peer("10.77.0.2:7001"), destination = b->peer("10.77.0.2:7002");
    a->device.write(b1("10.77.0.2", 7002, command));
    ASSERT_TRUE(until([&] { return destination->heard() == command; }));
    EXPECT_EQ(a->peers(), 0u);
    peer->send(endpoint("10.77.0.1:12333"), ask_parameter);
    ASSERT_TRUE(until([&] { return a->device.heard() == ask_parameter; }));
    ASSERT_EQ(a->peers(), 1u);
    EXPECT_EQ(a->gateway->link("tunnel").at("channels").at(0).at("peer"), "10.77.0.2:7001");
    a->device.write(telemetry);
    EXPECT_TRUE(until([&] { return peer->heard() == telemetry; }));
    a->device.write(parameter);
    EXPECT_TRUE(until([&] { return split(peer->heard()).frames.size() == 2; }));
    EXPECT_EQ(peer->heard(), telemetry + parameter);
    EXPECT_EQ(destination->heard(), command);
}

TEST_F(TwoGateways, datagrams_that_match_a_rule_are_wrapped_for_the_device) {
    anogate::WrapSettings rule;
    rule.from = *Network::parse("10.77.0.0/24");
    rule.link = "fc";
    rule.to = mcu;
    a->tunnel().wrap = {rule};
    rule.id = 0xB2;
    rule.source = 0xE7;
    b->tunnel().wrap = {rule};
    start();
    const auto ground = b->peer("10.77.0.2:7001");
    ground->send(endpoint("10.77.0.1:12333"), ask_parameter + command);
    const Bytes wrapped = frame(radio, mcu, 0xB1, ip4("10.77.0.2") + ip4("10.77.0.1") + le16(7001) + ask_parameter + command);
    EXPECT_TRUE(until([&] { return a->device.heard() == wrapped; }));
    EXPECT_EQ(a->count("wrapped"), 1u);
    EXPECT_EQ(a->count("in"), 1u);
    a->device.write(b1("10.77.0.2", 7001, parameter));    // to the address in the frame
    EXPECT_TRUE(until([&] { return ground->heard() == parameter; }));
    // A tunnel frame addressed to us is unwrapped before its content is wrapped again.
    const auto other = a->peer("10.77.0.1:7002");
    other->send(endpoint("10.77.0.2:12333"), b1("10.77.0.2", 0, ask_parameter, "1.1.1.1"));
    EXPECT_TRUE(until([&] { return b->device.heard() == frame(0xE7, mcu, 0xB2, Bytes{1, 2} + le16(7002) + ask_parameter); }));
}

TEST_F(TwoGateways, a_wrapped_datagram_is_split_by_the_links_max_data) {
    anogate::WrapSettings rule;
    rule.from = *Network::parse("10.77.0.2");
    rule.link = "fc";
    a->tunnel().wrap = {rule};
    a->settings.links[0].max_data = 198;
    start();
    const auto ground = b->peer("10.77.0.2:7001");
    Bytes sent;
    for (std::uint8_t i = 0; i < 60; ++i) sent = sent + frame(host, mcu, 0xF1, Bytes(i, i));
    const Bytes not_even_alone = frame(host, mcu, 0xF1, Bytes(190));
    ground->send(endpoint("10.77.0.1:12333"), sent + not_even_alone + command);
    Bytes inner;
    EXPECT_TRUE(until([&] {
        inner.clear();
        for (const Bytes& f : split(a->device.heard()).frames) {
            EXPECT_LE(f.size(), 198u + 8u);
            inner.insert(inner.end(), f.begin() + 16, f.end() - 2);
        }
        return inner.size() == sent.size() + command.size();
    }));
    EXPECT_EQ(inner, sent + command);
    EXPECT_EQ(a->count("tunnel_too_big"), 1u);
}

// The rules of the link apply to wrapped frames too.

TEST_F(TwoGateways, the_filters_of_the_receiving_link_apply_to_inner_frames) {
    a->settings.links[0].rules.receive.deny = {{0xF0, 0xF0}};
    a->settings.links[0].rules.receive.deny_destinations = {{0xDD, 0xDD}};
    start();
    const auto ground = b->peer("10.77.0.2:7001");
    const Bytes firmware = frame(host, mcu, 0xF0, {1, 2, 3}), elsewhere = frame(host, 0xDD, 0xE0, {0, 0, 0});
    for (const auto& wrapped :
         {b1("10.77.0.2", 7001, firmware + command + elsewhere), b2(2, 7001, firmware + command + elsewhere)})
        a->device.write(wrapped);
    EXPECT_TRUE(until([&] { return ground->heard().size() == 2 * command.size(); }));
    EXPECT_EQ(ground->heard(), command + command);
    EXPECT_EQ(a->gateway->count("fc", "denied_in"), 4u);
}

TEST_F(TwoGateways, the_filters_and_limits_of_the_tunnel_apply_to_inner_frames) {
    a->tunnel().rules.send.deny = {{0xF0, 0xF0}};
    a->tunnel().rules.limit = {{0xC0, 0.01}};
    b->tunnel().rules.receive.deny = {{0xE1, 0xE1}};
    start();
    const Bytes firmware = frame(host, mcu, 0xF0, {1, 2, 3});
    a->device.write(b1("10.77.0.2", 0, firmware + command + command + parameter + ask_parameter));
    EXPECT_TRUE(until([&] { return b->device.heard().size() >= (command + ask_parameter).size(); }));
    EXPECT_EQ(b->device.heard(), command + ask_parameter);
    EXPECT_EQ(a->gateway->count("tunnel", "denied_out"), 1u);
    EXPECT_EQ(a->gateway->count("tunnel", "limited"), 1u);
    EXPECT_EQ(b->gateway->count("tunnel", "denied_in"), 1u);
}

TEST_F(TwoGateways, the_filters_of_the_device_link_apply_to_frames_before_they_are_wrapped) {
    anogate::WrapSettings rule;
    rule.from = *Network::parse("10.77.0.0/24");
    rule.link = "fc";
    rule.to = mcu;
    a->tunnel().wrap = {rule};
    a->settings.links[0].rules.send.deny = {{0xE1, 0xE1}};
    a->settings.links[0].rules.limit = {{0xC0, 0.01}};
    start();
    const auto ground = b->peer("10.77.0.2:7001");
    ground->send(endpoint("10.77.0.1:12333"), parameter + command + command + ask_parameter);
    const Bytes wrapped = frame(radio, mcu, 0xB1, ip4("10.77.0.2") + ip4("10.77.0.1") + le16(7001) + command + ask_parameter);
    EXPECT_TRUE(until([&] { return !a->device.heard().empty(); }));
    EXPECT_EQ(a->device.heard(), wrapped);
    EXPECT_EQ(a->gateway->count("fc", "denied_out"), 1u);
    EXPECT_EQ(a->gateway->count("fc", "limited"), 1u);
}

// Attacks.

TEST_F(TwoGateways, tunnel_frames_of_a_device_reach_only_allowed_destinations) {
    start();
    const auto local = a->peer("127.0.0.1:0"), any = a->peer("0.0.0.0:0");
    std::uint64_t n = 0;
    for (const char* to : {"127.0.0.1", "10.77.0.1", "0.0.0.0", "224.0.0.1", "255.255.255.255", "10.77.0.255", "10.77.0.0",
                           "10.78.0.2", "8.8.8.8"})
        for (const std::uint16_t p : {local->port(), any->port(), port, std::uint16_t{0}}) {
            a->device.write(b1(to, p, command));
            ++n;
            ASSERT_TRUE(until([&] { return a->count("tunnel_not_allowed") == n; })) << to;
        }
    EXPECT_EQ(a->count("out"), 0u);
    EXPECT_TRUE(local->heard().empty() && any->heard().empty());
    EXPECT_EQ(a->peers(), 0u);
}

TEST_F(TwoGateways, tunnel_frames_of_a_device_never_reach_a_port_of_the_same_gateway) {
    a->tunnel().allow = {*Network::parse("127.0.0.0/8"), *Network::parse("10.77.0.1"), *Network::parse("10.77.0.2")};
    a->settings.links.push_back(udp_listen("ground", "0.0.0.0:0"));
    start();
    const std::uint16_t ground = a->gateway->port("ground");
    std::uint64_t n = 0;
    for (const char* to : {"127.0.0.1", "10.77.0.1"})
        for (const std::uint16_t p : {ground, port, std::uint16_t{0}}) {
            a->device.write(b1(to, p, command));
            ++n;
            ASSERT_TRUE(until([&] { return a->count("tunnel_own_port") == n; })) << to << ":" << p;
        }
    EXPECT_EQ(a->count("out"), 0u);
    EXPECT_EQ(a->gateway->count("ground", "bytes_in"), 0u);
    const auto local = a->peer("127.0.0.1:0");
    a->device.write(b1("127.0.0.1", local->port(), command));
    EXPECT_TRUE(until([&] { return local->heard() == command; })) << "a program beside us, for it is listed";
}

TEST_F(TwoGateways, a_gateway_does_not_relay_tunnel_frames_for_other_ip_addresses) {
    start();
    const auto attacker = b->peer("10.77.0.2:7001"), victim = b->peer("10.77.0.2:7002");
    const auto gateway = endpoint("10.77.0.1:12333");
    for (const char* to : {"10.77.0.2", "8.8.8.8", "255.255.255.255", "224.0.0.1"})
        attacker->send(gateway, b1(to, 7002, command));
    attacker->send(gateway, b2(2, 7002, command));
    EXPECT_TRUE(until([&] { return a->count("tunnel_other_ip") == 5; }));
    EXPECT_EQ(a->peers(), 0u) << "no channel for that";
    EXPECT_EQ(a->gateway->count("tunnel", "denied_in"), 5u);
    // A peer can do no more than this: the inner frames are for our devices, and a tunnel frame inside is data.
    attacker->send(gateway, b1("10.77.0.1", 0, b1("10.77.0.2", 7002, command)) + b1("10.77.0.2", 7002, command));
    EXPECT_TRUE(until([&] { return a->device.heard() == b1("10.77.0.2", 7002, command); }));
    EXPECT_EQ(a->count("tunnel_other_ip"), 6u);
    EXPECT_EQ(a->count("unwrapped"), 1u);
    EXPECT_EQ(a->count("out"), 0u);
    EXPECT_TRUE(victim->heard().empty());
}

TEST_F(TwoGateways, frames_from_senders_outside_allow_are_refused) {
    a->tunnel().allow = {*Network::parse("10.77.0.9")};
    start();
    const auto stranger = b->peer("10.77.0.2:7001");
    stranger->send(endpoint("10.77.0.1:12333"), command);
    stranger->send(endpoint("10.77.0.1:12333"), b1("10.77.0.1", 0, command));
    EXPECT_TRUE(until([&] { return a->count("tunnel_not_allowed") == 2; }));
    const auto local = a->peer("127.0.0.1:7001");
    local->send(endpoint("127.0.0.1:12333"), command);
    EXPECT_TRUE(until([&] { return a->count("tunnel_not_allowed") == 3; }));
    EXPECT_TRUE(a->device.heard().empty());
    EXPECT_EQ(a->gateway->count("tunnel", "denied_in"), 3u);
    EXPECT_EQ(a->gateway->link("tunnel").at("hint"), "senders outside `allow` were refused: add their network to `allow`");
}

TEST_F(TwoGateways, a_peer_does_not_receive_frames_for_a_pinned_address) {
    a->settings.routes = {{mcu, mcu, "fc"}};
    start();
    const auto thief = b->peer("10.77.0.2:7001"), user = b->peer("10.77.0.2:7002");
    thief->send(endpoint("10.77.0.1:12333"), frame(mcu, host, 0x03, {1, 2, 3, 4, 5, 6, 7}));
    user->send(endpoint("10.77.0.1:12333"), command);
    EXPECT_TRUE(until([&] { return split(a->device.heard()).frames.size() == 2; }));
    let_pass(20ms);
    EXPECT_TRUE(thief->heard().empty());
}

TEST_F(TwoGateways, a_tunnel_frame_larger_than_a_datagram_is_refused) {
    a->settings.links[0].max_data = 65535;
    a->settings.links[0].queue = 1 << 18;
    start();
    const Bytes big = b1("10.77.0.2", port, frame(host, mcu, 0xF1, Bytes(65508 - 8, 0x11)));
    std::size_t written = 0;
    EXPECT_TRUE(until([&] {
        written += a->device.write(std::span{big}.subspan(written));
        return a->count("tunnel_too_big") == 1;
    }));
    EXPECT_EQ(a->count("out"), 0u);
}

TEST_F(TwoGateways, a_storm_of_nested_tunnel_frames_ends) {
    a->tunnel().deliver = b->tunnel().deliver = Deliver::tunnel;
    start();
    const auto attacker = b->peer("10.77.0.2:7001");
    // After the first arrival, both ends of the cable know each other's hardware address; until then the kernel holds datagrams
    // back.
    attacker->send(endpoint("10.77.0.1:12333"), command);
    ASSERT_TRUE(until([&] { return a->count("in") == 1; }));
    Bytes nested = command;
    for (int depth = 0; depth < 100; ++depth)
        nested = b1(depth % 2 == 0 ? "10.77.0.1" : "10.77.0.2", port, nested, "10.77.0.2", everybody);
    const auto listen = [&] { return a->device.heard().size() + b->device.heard().size(); };
    std::uint64_t thrown = 1, written = 0;
    for (int i = 0; i < 300; ++i) {
        thrown += attacker->send(endpoint("10.77.0.1:12333"), nested);
        thrown += attacker->send(endpoint("10.77.0.1:12333"), b1("10.77.0.1", port, nested + nested, "10.77.0.1", everybody));
        if (i % 10 != 0) continue;
        written += b->device.write(b1("10.77.0.1", port, nested, "10.77.0.1", everybody)) > 0;
        a->step();
        b->step();
        listen();
    }
    const auto seen = [&] { return a->count("in") + a->count("out") + b->count("in") + b->count("out"); };
    EXPECT_TRUE(until([&] { return a->count("tunnel_nested") >= 300; })) << "all of it was read";
    EXPECT_TRUE(until([&] {
        const auto before = seen() + listen();
        let_pass(50ms);
        return seen() + listen() == before;
    }));
    EXPECT_LE(b->count("out"), written) << "one datagram a frame of the device";
    EXPECT_EQ(a->count("out"), 0u) << "what came in does not go out again by the tunnel";
    EXPECT_LE(a->count("in"), thrown + written);
    EXPECT_LE(b->count("in"), 10u) << "nor to a peer, who would open it; a probe a second may";
    const auto heard = a->device.heard().size();
    a->device.write(b1("10.77.0.2", port, ask_parameter));
    EXPECT_TRUE(until([&] {
        b->answer();
        return a->device.heard().size() > heard;
    })) << "and all is well afterwards";
    EXPECT_TRUE(a->gateway->counters_add_up() && b->gateway->counters_add_up());
}

// Each gateway has a link to the other's tunnel: frames that one sends through its tunnel return to it on the other's link.
class Ring : public TwoGateways, public testing::WithParamInterface<Combination> {
protected:
    void start_ring() {
        for (Site* site : {a.get(), b.get()}) {
            site->settings.links.push_back(udp("u", (site == a.get() ? "10.77.0.2:" : "10.77.0.1:") + std::to_string(port)));
            site->tunnel().links.push_back("u");
            site->tunnel().deliver = GetParam().deliver;
        }
        if (GetParam().brief) {
            anogate::WrapSettings rule;
            rule.from = *Network::parse("10.77.0.0/24");
            rule.link = "u";
            rule.to = radio;
            for (Site* site : {a.get(), b.get()}) {
                site->tunnel().wrap = {rule};
                site->tunnel().ip = IpAddress::parse("10.77.0.9");    // otherwise neither accepts the frames wrapped by the other
            }
        }
        start();
    }
    std::uint64_t seen() const {
        std::uint64_t frames = 0;
        for (const Site* site : {a.get(), b.get()})
            for (const char* link : {"fc", "u", "tunnel"}) frames += site->gateway->count(link, "frames_in");
        return frames;
    }
};

TEST_P(Ring, circulates_no_frame_endlessly) {
    start_ring();
    Bytes all;
    for (std::uint8_t depth = 0; depth < 10; ++depth) {    // each a different frame: a repeated one would be dropped
        Bytes inner = frame(mcu, everybody, 0x03, {depth, 2, 3, 4, 5, 6, 7});
        for (int i = 0; i < depth; ++i) inner = b1((depth - i) % 2 == 0 ? "10.77.0.1" : "10.77.0.2", port, inner);
        all = all + inner;
    }
    a->device.write(all);
    b->device.write(command);
    EXPECT_TRUE(until([&] { return seen() >= 10 + 1; })) << "what the devices sent";
    std::uint64_t before = 0;
    EXPECT_TRUE(until([&] {
        before = seen();
        let_pass(50ms);
        return seen() == before;
    }));
    EXPECT_LT(before, 4u * 10 * 1000) << "each its turns at most, on every link";
    EXPECT_TRUE(a->gateway->counters_add_up() && b->gateway->counters_add_up());
}

INSTANTIATE_TEST_SUITE_P(TwoGateways, Ring,
                         testing::Values(Combination{"frames", false, Deliver::frames},
                                         Combination{"tunnel", false, Deliver::tunnel},
                                         Combination{"frames_wrapped", true, Deliver::frames},
                                         Combination{"tunnel_wrapped", true, Deliver::tunnel}),
                         [](const auto& combination) { return std::string{combination.param.name}; });

TEST_F(TwoGateways, the_tunnel_works_again_after_the_cable_was_unplugged) {
    start();
    a->space.ip("link set cable down");
    EXPECT_TRUE(until([&] {
        a->device.write(b1("10.77.0.2", port, command));
        return a->count("tunnel_send_failed") + a->count("tunnel_not_allowed") > 0;
    }));
    a->space.ip("link set cable up");
    EXPECT_TRUE(until([&] {
        a->device.write(b1("10.77.0.2", port, command));
        return !b->device.heard().empty();
    }));
}

TEST_F(TwoGateways, the_tunnel_waits_for_a_port_in_use) {
    auto other = a->peer("0.0.0.0:12333");
    {
        const Inside inside{a->space};
        a->gateway = std::make_unique<RunningGateway>(a->settings);
        ASSERT_TRUE(a->gateway->until_up("fc") && a->gateway->until_waiting("tunnel"));
    }
    b->start();
    a->device.write(b1("10.77.0.2", port, command));
    EXPECT_TRUE(until([&] { return a->count("tunnel_down") == 1; }));
    other.reset();
    EXPECT_TRUE(until([&] {
        a->device.write(b1("10.77.0.2", port, command));
        return !b->device.heard().empty();
    }));
}

}    // namespace
}    // namespace tunnel_tests
