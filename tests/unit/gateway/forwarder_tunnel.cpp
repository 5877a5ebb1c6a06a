// The rules for a frame that is received in a tunnel frame, or sent in one.
#include "forwarding.hpp"

#include <gateway/tunnel/tunnel.hpp>

namespace forwarder_tunnel_tests {

using namespace forwarding;
using support::operator+;

namespace {

// Accepts tunnel frames like TunnelLink, without a socket.
class Port final : public TunnelPort {
public:
    explicit Port(Forwarder& forwarder) : forwarder_{forwarder} {}
    bool takes(ano::FrameView frame) const noexcept override { return is_tunnel_frame(frame) && frame.destination() == 0xE6; }
    void carry(Channel& from, ano::FrameView frame) override {
        ++carried;
        forwarder_.learn(from, frame, now);
        const auto content = unwrap(frame, {});
        InnerFrames inner{content->inner};
        while (const auto one = inner.next())
            if (forwarder_.passes_into_tunnel(from, *one, now)) left.emplace_back(one->bytes().begin(), one->bytes().end());
    }
    void refuse_nested() noexcept override { ++nested; }

    TimePoint now = start + 1s;
    int carried = 0, nested = 0;
    std::vector<Bytes> left;

private:
    Forwarder& forwarder_;
};

Bytes around(std::uint8_t source, std::uint8_t to, const Bytes& inner) {
    const Bytes head{10, 0, 0, 1, 10, 0, 0, 2, 0, 0};
    return frame(source, to, ip_tunnel, head + inner);
}

class Tunnelled : public Forwarding {
protected:
    Tunnelled() {
        forwarder.set_tunnel(way.link, LinkSet{device.link}, port);
        port.now = now += 1s;
    }
    Channel& device = add();
    Channel& ground = add();
    Channel& way = add_with([](ForwarderLink& link) { link.rules.send = without(0x07); });
    Port port{forwarder};
};

TEST_F(Tunnelled, a_tunnel_frame_of_a_device_ends_at_the_tunnel) {
    EXPECT_EQ(events(device, around(fc, 0xE6, telemetry)), (Lines{"received 0"}));
    EXPECT_EQ(port.left, Frames{telemetry});
    EXPECT_EQ(forwarder.router().learned(fc, now).links, LinkSet{device.link});
    EXPECT_EQ(events(ground, around(0xDD, 0xE6, telemetry)), (Lines{"received 1", "offered 0", "offered 2"}))
        << "of another link it goes on";
    EXPECT_EQ(port.carried, 1);
}

TEST_F(Tunnelled, a_refused_firmware_frame_does_not_pause_the_hello) {
    Forwarder own{{}, 8};
    const LinkId from = own.add_link({});
    ForwarderLink asked;
    asked.hello = 2s;
    asked.rules.send = without(0xF0);
    const LinkId to = own.add_link(asked);
    Port inner{own};
    inner.now = now;
    own.set_tunnel(to, LinkSet{from}, inner);
    Channel& channel = *own.open_channel(from, "", now);
    ASSERT_TRUE(own.open_channel(to, "", now));
    own.link_up(to, now);
    const auto due = own.hello_due();
    ASSERT_TRUE(due);
    own.receive(channel, ano::FrameView{around(fc, 0xE6, frame(fc, host, 0xF0, {1}))}, now);
    EXPECT_EQ(inner.carried, 1);
    EXPECT_TRUE(inner.left.empty());
    own.send_hellos(*due);
    EXPECT_EQ(own.hello_due(), *due + 2s);
}

TEST_F(Tunnelled, a_new_link_with_the_number_of_a_tunnelled_link_is_not_tunnelled) {
    const LinkId number = device.link;
    forwarder.remove_link(number);
    Channel& next = add();
    ASSERT_EQ(next.link, number);
    EXPECT_EQ(events(next, around(fc, 0xE6, telemetry)), (Lines{"received 0", "offered 1", "offered 2"}));
    EXPECT_EQ(port.carried, 0);
}

TEST_F(Tunnelled, a_switch_applies_to_frames_inside_a_tunnel_frame_of_a_device) {
    forwarder.inhibit().add(LinkSet{device.link});
    EXPECT_EQ(events(device, around(fc, 0xE6, telemetry + command)), (Lines{"received 0", "dropped 0 inhibited"}));
    EXPECT_EQ(port.left, Frames{telemetry});
    const Bytes nested = around(fc, 0x55, command);
    EXPECT_EQ(events(device, around(fc, 0xE6, nested)), (Lines{"received 0", "dropped 0 inhibited"})) << "nor deeper";
    EXPECT_EQ(events(device, nested), (Lines{"received 0", "dropped 0 inhibited"})) << "nor in one that goes on unopened";
    EXPECT_EQ(port.left.size(), 1u);
    EXPECT_EQ(device.routed.inhibited, 3u);
}

TEST_F(Tunnelled, inner_frames_obey_the_rules_of_both_links) {
    receive(device, around(fc, 0xE6, frame(fc, all, 0x07, {1}) + telemetry));
    EXPECT_EQ(port.left, Frames{telemetry});
    EXPECT_EQ(forwarder.traffic(way.link).gone_sent.denied_out, 1u);
    device.arrived_at = now;
    port.now = now + 2s;
    forwarder.receive(device, ano::FrameView{around(fc, 0xE6, frame(fc, all, 0x03, {2}))}, now);
    EXPECT_EQ(forwarder.traffic(way.link).gone_sent.stale, 1u) << "telemetry of two seconds ago";
    EXPECT_EQ(port.left.size(), 1u);
}

TEST_F(Tunnelled, frames_that_return_after_leaving_by_the_tunnel_are_dropped) {
    receive(device, around(fc, 0xE6, telemetry));
    receive(way, telemetry);
    Bytes probe;
    for (const Bytes& bytes : taken(way))
        if (is_probe(ano::FrameView{bytes})) probe = bytes;
    receive(ground, probe);
    EXPECT_EQ(events(way, telemetry).at(1), "dropped 2 looped");
    ground.arrived_at = now;
    EXPECT_FALSE(forwarder.passes_to_wrap(ground, ano::FrameView{telemetry}, device.link, now));
    EXPECT_EQ(ground.routed.looped, 2u) << "and the probe";
}

TEST_F(Tunnelled, a_tunnel_frame_from_inside_a_tunnel_frame_is_not_sent_back_by_that_tunnel) {
    EXPECT_EQ(events(way, around(0xDD, all, telemetry)), (Lines{"received 2", "offered 0", "offered 1"}));
    EXPECT_EQ(port.nested, 0) << "it would not go back there anyway";
    Channel& second = *forwarder.open_channel(way.link, "peer", now);
    forwarder.link_up(way.link, now);
    now += 1ms;
    const Bytes nested = around(0xDD, all, command);
    EXPECT_EQ(events(way, nested), (Lines{"received 2", "offered 0", "offered 1"}));
    EXPECT_EQ(port.nested, 1);
    EXPECT_EQ(second.sent().offered, 0u);
    EXPECT_EQ(events(second, nested), (Lines{"received 3", "offered 0", "offered 1", "said 2"}))
        << "it did not go there, so it comes for the first time";
}

// Frames that could not be wrapped are not counted as sent, and a sent one is one frame for all channels.
TEST_F(Tunnelled, wrapped_frames_obey_the_rules_of_the_link_of_their_devices) {
    Channel& limited = add_with([](ForwarderLink& link) {
        link.rules.limit = {{0x03, 1}};
        link.rules.receive = without(0x08);
    });
    diary.pop_all();
    way.arrived_at = now;
    EXPECT_TRUE(forwarder.passes_to_wrap(way, ano::FrameView{frame(0xDD, all, 0x03, {1})}, limited.link, now));
    EXPECT_EQ(diary.pop_all(), (Lines{"received 2"})) << "it is not offered until its tunnel frame is whole";
    EXPECT_EQ(limited.sent().offered, 0u);
    EXPECT_FALSE(forwarder.passes_to_wrap(way, ano::FrameView{frame(0xDD, all, 0x03, {2})}, limited.link, now));
    EXPECT_EQ(diary.pop_all(), (Lines{"received 2", "refused 3 limited"}));
    EXPECT_EQ(forwarder.router().learned(0xDD, now).links, LinkSet{}) << "answers go nowhere";
    const Bytes whole = around(0xE6, all, telemetry);
    forwarder.send(limited.link, ano::FrameView{whole}, now);
    EXPECT_EQ(taken(limited), Frames{whole});
    forwarder.close_channel(limited);
    forwarder.send(LinkId{3}, ano::FrameView{whole}, now);
    EXPECT_EQ(forwarder.traffic(LinkId{3}).gone_sent.link_down, 1u);
}

TEST_F(Tunnelled, a_removed_tunnel_receives_nothing) {
    forwarder.remove_link(way.link);
    EXPECT_EQ(events(device, around(fc, 0xE6, telemetry)), (Lines{"received 0", "offered 1"}));
    EXPECT_EQ(port.carried, 0);
}

}    // namespace
}    // namespace forwarder_tunnel_tests
