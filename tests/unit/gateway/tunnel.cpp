#include <gateway/tunnel/tunnel.hpp>
#include <support/allocations.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <utility>

namespace tunnel_tests {
namespace {

using anogate::Endpoint;
using anogate::IpAddress;
using anogate::Network;
using anogate::Tunnel;
using anogate::TunnelCounters;
using support::Bytes;
using support::frame;
using support::operator+;

constexpr std::uint8_t fc = 0xDC, host = 0xFE, radio = 0xE6, everybody = 0xFF;
constexpr std::uint16_t port = 12333, control_port = 8088;

IpAddress ip(const char* text) { return *IpAddress::parse(text); }
ano::FrameView view(const Bytes& bytes) { return *ano::frame_at(bytes); }
Bytes bytes_of(ano::FrameView f) { return {f.bytes().begin(), f.bytes().end()}; }
Bytes bytes_of(std::span<const std::uint8_t> s) { return {s.begin(), s.end()}; }

// We are 192.168.0.5/24; the default route is there too.
struct Site {
    anogate::TunnelSettings settings;
    std::uint8_t own_id = 199;
    std::optional<IpAddress> ours = ip("192.168.0.5");
    Tunnel tunnel() {
        Tunnel t{settings,
                 own_id,
                 {[this](const IpAddress& there) {
                      asked = there;
                      return settings.ip ? settings.ip : ours;
                  },
                  [](std::uint16_t p) { return p == control_port; }}};
        t.set_networks({*Network::parse("127.0.0.1/8"), *Network::parse("192.168.0.5/24")});
        return t;
    }
    IpAddress asked;
};

const Bytes euler = frame(fc, host, 0x03, {1, 2, 3, 4, 5, 6, 7});
const Bytes command = frame(host, fc, 0xC0, {0, 1, 2});

/// DATA of an 0xB1 frame.
Bytes head_b1(const char* source, const char* destination, std::uint16_t p) {
    Bytes head;
    for (const char* text : {source, destination})
        for (std::size_t i = 0; i < 4; ++i) head.push_back(ip(text).bytes[i]);
    return head + Bytes{static_cast<std::uint8_t>(p), static_cast<std::uint8_t>(p >> 8)};
}
Bytes b1(const char* destination, std::uint16_t p, const Bytes& inner, std::uint8_t to = radio, const char* source = "0.0.0.0") {
    return frame(fc, to, 0xB1, head_b1(source, destination, p) + inner);
}
Bytes b2(std::uint8_t destination, std::uint16_t p, const Bytes& inner, std::uint8_t source = 0) {
    return frame(fc, radio, 0xB2,
                 Bytes{source, destination, static_cast<std::uint8_t>(p), static_cast<std::uint8_t>(p >> 8)} + inner);
}

const Tunnel::Passes all = [](ano::FrameView) { return true; };

/// The total of refused frames, for all causes.
std::uint64_t refused(const TunnelCounters& c) {
    std::uint64_t sum = 0;
    for (const auto& row : anogate::tunnel_counters)
        if (row.name.starts_with("tunnel_")) sum += c.*row.value;
    return sum;
}

struct In {
    bool taken;
    std::vector<Bytes> frames;
};
In in(Tunnel& tunnel, const Bytes& tunnel_frame, const char* sender) {
    In result;
    result.taken = tunnel.in(view(tunnel_frame), ip(sender), [&](ano::FrameView f) { result.frames.push_back(bytes_of(f)); });
    return result;
}

TEST(unwrap, splits_0xB1_into_header_and_inner_frames) {
    const Bytes whole = b1("192.168.0.20", 6670, euler, radio, "1.2.3.4");
    const auto content = anogate::unwrap(view(whole), {});
    ASSERT_TRUE(content);
    EXPECT_EQ(content->head, (anogate::TunnelHead{ip("1.2.3.4"), ip("192.168.0.20"), 6670}));
    EXPECT_EQ(bytes_of(content->inner), euler);
}

TEST(unwrap, completes_0xB2_with_the_network) {
    const Bytes whole = b2(20, 6670, euler, 7);
    const auto content = anogate::unwrap(view(whole), ip("10.1.2.99"));
    ASSERT_TRUE(content);
    EXPECT_EQ(content->head, (anogate::TunnelHead{ip("10.1.2.7"), ip("10.1.2.20"), 6670}));
    EXPECT_EQ(bytes_of(content->inner), euler);
}

TEST(unwrap, rejects_DATA_of_any_length_shorter_than_its_header) {
    for (std::size_t n = 0; n <= 10; ++n) {
        const Bytes long_form = frame(fc, radio, 0xB1, Bytes(n, 1)), short_form = frame(fc, radio, 0xB2, Bytes(n, 1));
        EXPECT_EQ(anogate::unwrap(view(long_form), {}).has_value(), n >= 10) << n;
        EXPECT_EQ(anogate::unwrap(view(short_form), {}).has_value(), n >= 4) << n;
    }
    EXPECT_FALSE(anogate::unwrap(view(frame(fc, radio, 0xB0, Bytes(20, 1))), {}));
}

TEST(InnerFrames, ends_at_the_first_byte_that_starts_no_valid_frame) {
    const Bytes cut{command.begin(), command.end() - 1};
    for (const auto& [inner, whole, good] : {std::tuple{euler, 1, true},
                                             {euler + command, 2, true},
                                             {Bytes{}, 0, false},
                                             {Bytes{0xAB}, 0, false},
                                             {euler + cut, 1, false},
                                             {cut + euler, 0, false},
                                             {euler + Bytes{0} + command, 1, false}}) {
        anogate::InnerFrames frames{inner};
        int n = 0;
        while (frames.next()) ++n;
        EXPECT_EQ(n, whole);
        EXPECT_EQ(frames.good(), good);
    }
}

TEST(InnerFrames, does_not_look_inside_a_damaged_tunnel_frame) {
    Bytes damaged = b1("192.168.0.20", 0, euler);
    damaged.back() ^= 1;
    anogate::InnerFrames frames{damaged};
    EXPECT_FALSE(frames.next());
    EXPECT_FALSE(frames.good());
}

TEST(Tunnel, accepts_tunnel_frames_to_the_gateway_to_the_tunnel_address_and_to_broadcast) {
    Site site;
    const Tunnel tunnel = site.tunnel();
    for (const std::uint8_t id : {std::uint8_t{0xB1}, std::uint8_t{0xB2}}) {
        EXPECT_TRUE(tunnel.takes(view(frame(fc, radio, id))));
        EXPECT_TRUE(tunnel.takes(view(frame(fc, 199, id))));
        EXPECT_TRUE(tunnel.takes(view(frame(fc, everybody, id))));
        EXPECT_FALSE(tunnel.takes(view(frame(fc, host, id))));
        EXPECT_FALSE(tunnel.takes(view(frame(fc, 0, id))));
    }
    EXPECT_FALSE(tunnel.takes(view(frame(fc, radio, 0xB0))));
    EXPECT_FALSE(tunnel.takes(view(frame(fc, radio, 0xB3))));
    site.own_id = 0;
    EXPECT_FALSE(site.tunnel().takes(view(frame(fc, 0, 0xB1)))) << "no id is not the id 0";
    site.settings.address = 30;
    EXPECT_TRUE(site.tunnel().takes(view(frame(fc, 30, 0xB1))));
    EXPECT_FALSE(site.tunnel().takes(view(frame(fc, radio, 0xB1))));
}

TEST(Tunnel, sends_the_inner_frames_as_one_datagram) {
    Site site;
    Tunnel tunnel = site.tunnel();
    const auto datagram = tunnel.out(view(b1("192.168.0.20", 6670, euler + command)), all);
    ASSERT_TRUE(datagram);
    EXPECT_EQ(datagram->to, (Endpoint{ip("192.168.0.20"), 6670}));
    EXPECT_EQ(bytes_of(datagram->bytes), euler + command);
    EXPECT_EQ(refused(tunnel.counters()), 0u);
}

TEST(Tunnel, sends_the_short_form_only_to_the_network_of_the_gateway) {
    Site site;
    Tunnel tunnel = site.tunnel();
    const auto datagram = tunnel.out(view(b2(20, 6670, euler)), all);
    ASSERT_TRUE(datagram);
    EXPECT_EQ(datagram->to, (Endpoint{ip("192.168.0.20"), 6670}));
    EXPECT_EQ(bytes_of(datagram->bytes), euler);

    site.settings.ip = ip("10.7.7.1");
    site.settings.allow = {*Network::parse("10.7.7.0/24")};
    tunnel = site.tunnel();
    EXPECT_EQ(tunnel.out(view(b2(20, 6670, euler)), all)->to.address, ip("10.7.7.20"));

    site.settings.ip.reset();
    site.ours.reset();
    tunnel = site.tunnel();
    EXPECT_FALSE(tunnel.out(view(b2(20, 6670, euler)), all));
    EXPECT_EQ(tunnel.counters().tunnel_no_way, 1u);
}

TEST(Tunnel, uses_the_tunnel_port_for_port_0) {
    Site site;
    Tunnel tunnel = site.tunnel();
    EXPECT_EQ(tunnel.out(view(b1("192.168.0.20", 0, euler)), all)->to.port, port);
    EXPECT_EQ(tunnel.out(view(b2(20, 0, euler)), all)->to.port, port);
    tunnel.set_port(40000);
    EXPECT_EQ(tunnel.out(view(b1("192.168.0.20", 0, euler)), all)->to.port, 40000);
}

TEST(Tunnel, inserts_the_ip_of_the_gateway_and_both_checksums_when_it_delivers_tunnel_frames) {
    Site site;
    site.settings.deliver = anogate::Deliver::tunnel;
    Tunnel tunnel = site.tunnel();
    const auto whole = tunnel.out(view(b1("192.168.0.20", 6670, euler + command, radio, "6.6.6.6")), all);
    ASSERT_TRUE(whole);
    EXPECT_EQ(site.asked, ip("192.168.0.20"));
    EXPECT_EQ(bytes_of(whole->bytes), b1("192.168.0.20", 6670, euler + command, radio, "192.168.0.5"));

    const auto brief = tunnel.out(view(b2(20, 0, euler, 66)), all);
    ASSERT_TRUE(brief);
    EXPECT_EQ(bytes_of(brief->bytes), b2(20, 0, euler, 5));

    site.ours.reset();
    EXPECT_FALSE(tunnel.out(view(b1("192.168.0.20", 6670, euler)), all));
    EXPECT_EQ(tunnel.counters().tunnel_no_way, 1u);
}

TEST(Tunnel, counts_and_drops_inner_bytes_that_are_no_valid_frame) {
    Site site;
    for (const auto deliver : {anogate::Deliver::frames, anogate::Deliver::tunnel}) {
        site.settings.deliver = deliver;
        Tunnel tunnel = site.tunnel();
        const bool frames = deliver == anogate::Deliver::frames;
        const Bytes cut{command.begin(), command.end() - 1};
        const auto part = tunnel.out(view(b1("192.168.0.20", 1, euler + cut)), all);
        ASSERT_TRUE(part);
        EXPECT_EQ(bytes_of(part->bytes), frames ? euler : b1("192.168.0.20", 1, euler, radio, "192.168.0.5"));
        EXPECT_EQ(tunnel.counters().tunnel_bad_inner, 1u);
        for (const Bytes& inner : {cut, Bytes{}, Bytes{0xAB}, Bytes(50, 0x55)})
            EXPECT_FALSE(tunnel.out(view(b1("192.168.0.20", 1, inner)), all));
        EXPECT_EQ(tunnel.counters().tunnel_bad_inner, 5u);
        EXPECT_FALSE(tunnel.out(view(frame(fc, radio, 0xB1, Bytes(9, 0))), all));
        EXPECT_EQ(tunnel.counters().tunnel_malformed, 1u);
    }
}

TEST(Tunnel, applies_the_filter_to_the_inner_frames) {
    Site site;
    const Tunnel::Passes no_commands = [](ano::FrameView f) { return f.id() != 0xC0; };
    Tunnel tunnel = site.tunnel();
    EXPECT_EQ(bytes_of(tunnel.out(view(b1("192.168.0.20", 1, command + euler + command)), no_commands)->bytes), euler);
    EXPECT_FALSE(tunnel.out(view(b1("192.168.0.20", 1, command)), no_commands));
    EXPECT_EQ(refused(tunnel.counters()), 0u) << "counted where it was refused";
    site.settings.deliver = anogate::Deliver::tunnel;
    tunnel = site.tunnel();
    EXPECT_EQ(bytes_of(tunnel.out(view(b1("192.168.0.20", 1, command + euler)), no_commands)->bytes),
              b1("192.168.0.20", 1, euler, radio, "192.168.0.5"));
}

TEST(Tunnel, sends_frames_of_a_device_to_allowed_addresses_only) {
    Site site;
    Tunnel tunnel = site.tunnel();
    std::uint64_t n = 0;
    for (const char* to : {"127.0.0.1", "224.0.0.1", "255.255.255.255", "0.0.0.0", "192.168.0.255", "192.168.0.5", "8.8.8.8",
                           "192.168.1.7", "240.0.0.1"}) {
        for (const std::uint16_t p : {std::uint16_t{0}, port, control_port, std::uint16_t{53}}) {
            EXPECT_FALSE(tunnel.out(view(b1(to, p, euler)), all)) << to;
            EXPECT_EQ(tunnel.counters().tunnel_not_allowed, ++n);
        }
    }
    EXPECT_FALSE(tunnel.out(view(b2(255, 1, euler)), all));
    EXPECT_FALSE(tunnel.out(view(b2(0, 1, euler)), all));
    EXPECT_FALSE(tunnel.out(view(b2(5, 1, euler)), all));
    EXPECT_EQ(refused(tunnel.counters()), n + 3);
}

TEST(Tunnel, never_sends_frames_of_a_device_to_ports_of_the_gateway) {
    Site site;
    site.settings.allow = {*Network::parse("127.0.0.0/8"), *Network::parse("192.168.0.5"), *Network::parse("192.168.0.0/24")};
    Tunnel tunnel = site.tunnel();
    for (const char* us : {"127.0.0.1", "127.8.8.8", "192.168.0.5"}) {
        EXPECT_TRUE(tunnel.out(view(b1(us, 6670, euler)), all));
        for (const std::uint16_t p : {std::uint16_t{0}, port, control_port})
            EXPECT_FALSE(tunnel.out(view(b1(us, p, euler)), all)) << us << " " << p;
    }
    EXPECT_EQ(tunnel.counters().tunnel_own_port, 9u);
    EXPECT_TRUE(tunnel.out(view(b1("192.168.0.20", port, euler)), all)) << "another's port of that number";
}

TEST(Tunnel, rejects_frames_that_do_not_fit_into_a_datagram) {
    Site site;
    Tunnel tunnel = site.tunnel();
    const auto filled = [](std::size_t size) { return frame(fc, host, 0xF1, Bytes(size - ano::overhead)); };
    EXPECT_EQ(tunnel.out(view(b1("192.168.0.20", 1, filled(65507))), all)->bytes.size(), 65507u);
    EXPECT_FALSE(tunnel.out(view(b1("192.168.0.20", 1, filled(65508))), all));
    EXPECT_FALSE(tunnel.out(view(b1("192.168.0.20", 1, filled(65525))), all)) << "all that a frame holds";
    site.settings.deliver = anogate::Deliver::tunnel;
    Tunnel whole = site.tunnel();
    EXPECT_EQ(whole.out(view(b1("192.168.0.20", 1, filled(65507 - 18))), all)->bytes.size(), 65507u);
    EXPECT_FALSE(whole.out(view(b1("192.168.0.20", 1, filled(65507 - 17))), all));
    EXPECT_EQ(tunnel.counters().tunnel_too_big + whole.counters().tunnel_too_big, 3u);
}

TEST(Tunnel, unwraps_a_tunnel_frame_to_the_gateway_one_level_deep) {
    Site site;
    Tunnel tunnel = site.tunnel();
    const Bytes nested = b1("192.168.0.5", 0, command);
    const In got = in(tunnel, b1("192.168.0.5", 0, euler + nested), "192.168.0.20");
    EXPECT_TRUE(got.taken);
    EXPECT_EQ(got.frames, (std::vector<Bytes>{euler, nested}));
    EXPECT_EQ(tunnel.counters().unwrapped, 1u);
    EXPECT_EQ(refused(tunnel.counters()), 0u);
}

TEST(Tunnel, does_not_relay_a_tunnel_frame_for_another_address) {
    Site site;
    Tunnel tunnel = site.tunnel();
    std::uint64_t n = 0;
    for (const char* to :
         {"192.168.0.20", "192.168.0.21", "8.8.8.8", "255.255.255.255", "224.0.0.1", "0.0.0.0", "192.168.0.255"}) {
        const In got = in(tunnel, b1(to, 0, euler), "192.168.0.20");
        EXPECT_FALSE(got.taken);
        EXPECT_TRUE(got.frames.empty());
        EXPECT_EQ(tunnel.counters().tunnel_other_ip, ++n);
    }
    site.settings.ip = ip("203.0.113.9");
    Tunnel behind_nat = site.tunnel();
    EXPECT_TRUE(in(behind_nat, b1("203.0.113.9", 0, euler), "192.168.0.20").taken);
    EXPECT_FALSE(in(behind_nat, b1("192.168.0.5", 0, euler), "192.168.0.20").taken);
}

TEST(Tunnel, completes_a_received_short_form_with_the_network_of_its_sender) {
    Site site;
    Tunnel tunnel = site.tunnel();
    EXPECT_TRUE(in(tunnel, b2(5, 0, euler), "192.168.0.20").taken);
    EXPECT_FALSE(in(tunnel, b2(6, 0, euler), "192.168.0.20").taken);
    EXPECT_FALSE(in(tunnel, b2(5, 0, euler), "10.0.0.20").taken) << "that is 10.0.0.5, not us";
    EXPECT_EQ(tunnel.counters().tunnel_other_ip, 2u);
}

TEST(Tunnel, counts_invalid_bytes_of_received_tunnel_frames_too) {
    Site site;
    Tunnel tunnel = site.tunnel();
    const In got = in(tunnel, b1("192.168.0.5", 0, euler + Bytes{1, 2, 3}), "192.168.0.20");
    EXPECT_EQ(got.frames, std::vector<Bytes>{euler});
    EXPECT_FALSE(in(tunnel, b1("192.168.0.5", 0, {}), "192.168.0.20").taken);
    EXPECT_FALSE(in(tunnel, frame(fc, radio, 0xB1, Bytes(5, 0)), "192.168.0.20").taken);
    EXPECT_EQ(tunnel.counters().tunnel_bad_inner, 2u);
    EXPECT_EQ(tunnel.counters().tunnel_malformed, 1u);
    EXPECT_EQ(tunnel.counters().unwrapped, 1u);
}

TEST(Tunnel, accepts_datagrams_from_allowed_senders_only) {
    Site site;
    Tunnel tunnel = site.tunnel();
    EXPECT_TRUE(tunnel.admits({ip("192.168.0.20"), 5000}));
    EXPECT_EQ(refused(tunnel.counters()), 0u);
    EXPECT_FALSE(tunnel.admits({ip("192.168.0.20"), 0}));
    for (const char* from : {"8.8.8.8", "127.0.0.1", "192.168.0.5", "192.168.0.255", "224.0.0.1", "0.0.0.0"})
        EXPECT_FALSE(tunnel.admits({ip(from), 5000})) << from;
    EXPECT_EQ(tunnel.counters().tunnel_not_allowed, 7u);
    site.settings.allow = {*Network::parse("127.0.0.0/8")};
    tunnel = site.tunnel();
    EXPECT_TRUE(tunnel.admits({ip("127.0.0.1"), 5000}));
    EXPECT_FALSE(tunnel.admits({ip("127.0.0.1"), port})) << "ourselves";
    EXPECT_EQ(tunnel.counters().tunnel_own_port, 1u);
}

// Wrapping.

struct Wrapping : testing::Test {
    Site site;
    anogate::WrapSettings& rule(const char* from) {
        auto& r = site.settings.wrap.emplace_back();
        r.from = *Network::parse(from);
        r.to = fc;
        return r;
    }
    std::vector<Bytes> sent;
    Tunnel::OnFrame send = [this](ano::FrameView f) { sent.push_back(bytes_of(f)); };
    Endpoint sender{ip("192.168.0.20"), 6670};

    void wrap(Tunnel& tunnel, std::initializer_list<Bytes> frames, std::size_t max_data = 4096) {
        ASSERT_TRUE(tunnel.begin_wrap(0, max_data, sender));
        for (const Bytes& f : frames) tunnel.add_to_wrap(view(f), send);
        tunnel.end_wrap(send);
    }
};

TEST_F(Wrapping, the_first_rule_that_matches_the_sender_counts) {
    rule("192.168.0.20");
    rule("192.168.0.0/24");
    const Tunnel tunnel = site.tunnel();
    EXPECT_EQ(tunnel.wrap_rule(ip("192.168.0.20")), 0u);
    EXPECT_EQ(tunnel.wrap_rule(ip("192.168.0.21")), 1u);
    EXPECT_FALSE(tunnel.wrap_rule(ip("10.0.0.1")));
}

TEST_F(Wrapping, the_frames_of_a_datagram_are_wrapped_together) {
    rule("192.168.0.0/24").source = 0xE7;
    Tunnel tunnel = site.tunnel();
    wrap(tunnel, {euler, command});
    EXPECT_EQ(sent, (std::vector<Bytes>{frame(0xE7, fc, 0xB1, head_b1("192.168.0.20", "192.168.0.5", 6670) + euler + command)}));
    EXPECT_EQ(tunnel.counters().wrapped, 1u);
    EXPECT_EQ(site.asked, sender.address);
}

TEST_F(Wrapping, stores_the_last_bytes_of_the_addresses_in_the_short_form) {
    rule("192.168.0.0/24").id = 0xB2;
    Tunnel tunnel = site.tunnel();
    wrap(tunnel, {euler});
    EXPECT_EQ(sent, (std::vector<Bytes>{frame(radio, fc, 0xB2, Bytes{20, 5, 0x0E, 0x1A} + euler)}));
}

TEST_F(Wrapping, rejects_a_sender_in_another_network_for_the_short_form) {
    rule("0.0.0.0/0").id = 0xB2;
    Tunnel tunnel = site.tunnel();
    EXPECT_FALSE(tunnel.begin_wrap(0, 4096, {ip("192.168.1.20"), 1}));
    EXPECT_EQ(tunnel.counters().tunnel_other_network, 1u);
    site.ours.reset();
    EXPECT_FALSE(tunnel.begin_wrap(0, 4096, sender));
    EXPECT_EQ(tunnel.counters().tunnel_no_way, 1u);
}

TEST_F(Wrapping, counts_a_datagram_that_cannot_be_wrapped_once_and_wraps_the_next) {
    rule("0.0.0.0/0");
    Tunnel tunnel = site.tunnel();
    const auto none = [](ano::FrameView) { FAIL(); };
    const auto ours = std::exchange(site.ours, std::nullopt);
    EXPECT_FALSE(tunnel.begin_wrap(0, 4096, sender));
    EXPECT_FALSE(tunnel.can_wrap()) << "its other frames are not even looked at";
    EXPECT_FALSE(tunnel.wrapping());
    tunnel.end_wrap(none);
    EXPECT_TRUE(tunnel.can_wrap());
    site.ours = ours;
    ASSERT_TRUE(tunnel.begin_wrap(0, 4096, sender));
    EXPECT_EQ(tunnel.wrapping(), std::optional<std::size_t>{0});
    tunnel.end_wrap(none);    // no frame passed
    EXPECT_FALSE(tunnel.wrapping());
    wrap(tunnel, {euler});
    EXPECT_EQ(sent.size(), 1u);
    EXPECT_EQ(tunnel.counters().wrapped, 1u);
    EXPECT_EQ(tunnel.counters().tunnel_no_way, 1u);
}

TEST_F(Wrapping, splits_between_frames_and_never_inside_one) {
    rule("192.168.0.0/24");
    Tunnel tunnel = site.tunnel();
    const Bytes head = head_b1("192.168.0.20", "192.168.0.5", 6670);
    const std::size_t two = head.size() + euler.size() + command.size();
    wrap(tunnel, {euler, command, euler}, two);
    EXPECT_EQ(sent, (std::vector<Bytes>{frame(radio, fc, 0xB1, head + euler + command), frame(radio, fc, 0xB1, head + euler)}));
    sent.clear();
    wrap(tunnel, {euler, command, euler}, two - 1);
    EXPECT_EQ(sent, (std::vector<Bytes>{frame(radio, fc, 0xB1, head + euler), frame(radio, fc, 0xB1, head + command),
                                        frame(radio, fc, 0xB1, head + euler)}));
}

TEST_F(Wrapping, drops_a_frame_that_is_too_big_and_sends_the_frames_around_it) {
    rule("192.168.0.0/24");
    Tunnel tunnel = site.tunnel();
    wrap(tunnel, {command, frame(host, fc, 0xF1, Bytes(200)), command}, 100);
    EXPECT_EQ(sent.size(), 2u);
    EXPECT_EQ(tunnel.counters().tunnel_too_big, 1u);
    EXPECT_EQ(tunnel.counters().wrapped, 2u);
    sent.clear();
    for (const std::size_t tiny : {0u, 9u, 10u, 17u}) wrap(tunnel, {command}, tiny);
    EXPECT_TRUE(sent.empty());
    EXPECT_EQ(tunnel.counters().tunnel_too_big, 5u);
}

TEST_F(Wrapping, sends_nothing_for_an_empty_datagram) {
    rule("192.168.0.0/24");
    Tunnel tunnel = site.tunnel();
    wrap(tunnel, {});
    EXPECT_TRUE(sent.empty());
    EXPECT_EQ(tunnel.counters().wrapped, 0u);
}

TEST_F(Wrapping, and_unwrapping_allocate_no_memory) {
    rule("192.168.0.0/24");
    site.settings.deliver = anogate::Deliver::tunnel;
    Tunnel tunnel = site.tunnel();
    const Bytes out = b1("192.168.0.20", 0, euler + command), from_outside = b1("192.168.0.5", 0, euler + command);
    std::size_t taken = 0;
    const Tunnel::OnFrame count = [&](ano::FrameView) { ++taken; };
    const auto before = support::allocations;
    for (int i = 0; i < 100; ++i) {
        (void)tunnel.out(view(out), all);
        (void)tunnel.in(view(from_outside), sender.address, count);
        (void)tunnel.begin_wrap(0, 30, sender);
        tunnel.add_to_wrap(view(euler), count);
        tunnel.add_to_wrap(view(command), count);
        tunnel.end_wrap(count);
    }
    EXPECT_EQ(support::allocations, before);
    EXPECT_EQ(taken, 400u);
}

}    // namespace
}    // namespace tunnel_tests
