#include "routing_net.hpp"

using namespace routing;

namespace router_tests {
namespace {

TEST(Router, a_broadcast_is_sent_everywhere_except_back) {
    Net net{{}, {{}, {}, {.broadcast = false}, {}}};
    expect(net.route(0, 0xDC, 0xFF), channels({1, 3}), Via::broadcast);
    expect(net.route(2, 0xDD, 0xFF), channels({0, 1, 3}), Via::broadcast);
}

TEST(Router, frames_for_a_port_id_are_sent_to_the_link_that_has_it) {
    Net net{{}, {{}, {.port_id = 5}, {}, {}}};
    expect(net.route(0, 0xFE, 5), channels({1}), Via::port);
    net.route(2, 5, 0xFE);
    expect(net.route(0, 0xFE, 5), channels({1}), Via::port);    // whatever address is behind it
    expect(net.route(1, 0xFE, 5), {}, Via::port);               // not sent back
}

TEST(Router, a_port_id_without_a_link_is_an_ordinary_address) {
    Net net;
    net.route(2, 7, 0xFE);
    expect(net.route(0, 0xFE, 7), channels({2}), Via::learned);
}

TEST(Router, frames_for_a_pinned_address_are_sent_to_its_links_wherever_it_was_seen) {
    Net net;
    net->pin(30, 40, link(1));
    net->pin(40, 40, link(2));
    net.route(3, 30, 0xFF);
    expect(net.route(0, 0xFE, 30), channels({1}), Via::pinned);
    expect(net.route(0, 0xFE, 40), channels({1, 2}), Via::pinned);
    expect(net.route(1, 0xFE, 40), channels({2}), Via::pinned);
    EXPECT_EQ(net.route(0, 0xFE, 41).via, Via::unknown);
    EXPECT_EQ(net->pinned(40), links({1, 2}));
    net->pin(0xFF, 0xFF, link(1));    // the last address ends the range
    EXPECT_EQ(net->pinned(0), LinkSet{});
}

TEST(Router, link_without_a_channel_is_absent) {
    Net net;
    const LinkId listener = net->add_link({.port_id = 9});
    net->pin(50, 50, listener);
    net->pin(50, 50, link(1));
    expect(net.route(0, 0xFE, 9), {}, Via::port, LinkSet{listener});
    expect(net.route(0, 0xFE, 50), channels({1}), Via::pinned, LinkSet{listener});
}

TEST(Router, a_link_with_several_channels_sends_to_all_except_the_source_channel) {
    Net net;
    net->open(channel(10), link(1));
    net->open(channel(11), link(1));
    net->pin(50, 50, link(1));
    expect(net.route(0, 0xFE, 50), channels({1, 10, 11}), Via::pinned);
    expect(net.route(10, 0xFE, 50), channels({1, 11}), Via::pinned);
}

TEST(Router, frames_for_a_learned_address_are_sent_where_it_was_seen) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    expect(net.route(1, 0xFE, 0xDC), {}, Via::learned);    // a neighbour on the same line, which has received it already
}

TEST(Router, a_learned_address_expires_after_its_time) {
    Net net{settings([](auto& s) { s.forget_after = 10s; })};
    net.route(1, 0xDC, 0xFF);
    net.now += 10s - 1ns;
    EXPECT_EQ(net.route(0, 0xFE, 0xDC).via, Via::learned);
    EXPECT_EQ(net->learned(0xDC, net.now).links, links({1}));
    net.now += 1ns;
    EXPECT_EQ(net->learned(0xDC, net.now).links, LinkSet{});
    expect(net.route(0, 0xFE, 0xDC), channels({1, 2, 3}), Via::unknown);
}

TEST(Router, frames_for_a_host_whose_links_are_down_are_also_sent_where_no_device_was_seen) {
    Net net;
    for (const unsigned n : {1u, 2u}) net.route(n, 0xFE, 0xFF);
    net->went_down(channel(1));
    expect(net.route(0, 0xDC, 0xFE), channels({1, 2}), Via::learned);
    net->went_down(channel(2));
    expect(net.route(0, 0xDC, 0xFE), channels({1, 2, 3}), Via::unknown);
    expect(net->find(link(0), 0xFE, net.now), channels({1, 2, 3}), Via::unknown);    // channel 0 has only a device
    EXPECT_TRUE(net.route(0, 0xDC, 0xFE).host_is_down);
    EXPECT_FALSE(net.route(0, 0xDC, 0xD2).host_is_down) << "it was never heard";
    net.route(1, 30, 0xFF);
    expect(net.route(0, 0xFE, 30), channels({1}), Via::learned);    // a device keeps its route
    net->came_up(channel(1));
    expect(net.route(3, 0xDC, 0xFE), channels({0, 1, 2}), Via::learned);    // 0 also sent as the host
}

TEST(Router, frames_for_a_host_whose_links_are_down_follow_the_rule_for_unknown_addresses) {
    Net dropping{settings([](GatewaySettings& s) { s.unknown = Unknown::drop; })};
    dropping.route(1, 0xFE, 0xFF);
    dropping->went_down(channel(1));
    expect(dropping.route(0, 0xDC, 0xFE), channels({1}), Via::learned);
    Net leading{settings([](GatewaySettings& s) { s.unknown = Unknown::link; })};
    leading->set_unknown_link(link(3));
    leading.route(1, 0xFE, 0xFF);
    leading->went_down(channel(1));
    expect(leading.route(0, 0xDC, 0xFE), channels({1, 3}), Via::unknown);
}

TEST(Router, a_host_is_reached_by_the_other_links_of_its_group_while_one_is_down) {
    Net net{{}, {{}, {.group = 1}, {.group = 1}, {}}};
    net.route(1, 0xFE, 0xFF);
    net->went_down(channel(1));
    expect(net.route(0, 0xDC, 0xFE), channels({2}), Via::learned);
    net->went_down(channel(2));
    EXPECT_EQ(net.route(0, 0xDC, 0xFE).channels & channels({0, 3}), channels({3}));
}

TEST(Router, hosts_stay_on_every_channel_until_it_closes) {
    Net net;
    for (const std::uint8_t host : {ano::address::host, ano::address::ros_bridge}) {
        net.route(1, host, 0xFF);
        net.route(2, host, 0xFF);
    }
    net.now += 24h;
    for (const std::uint8_t host : {ano::address::host, ano::address::ros_bridge}) {
        expect(net.route(0, 0xDC, host), channels({1, 2}), Via::learned);
        EXPECT_EQ(net->learned(host, net.now).links, links({1, 2}));
    }
    net->close(channel(1));
    expect(net.route(0, 0xDC, 0xFE), channels({2}), Via::learned);
    net->open(channel(1), link(1));    // the reused number has no earlier state
    expect(net.route(0, 0xDC, 0xFE), channels({2}), Via::learned);
    EXPECT_TRUE(net->conflicts(net.now).empty());
}

TEST(Router, unknown_addresses_are_flooded_dropped_or_sent_to_one_link) {
    Net flood{{}, {{}, {}, {.flood = false}, {}}};
    expect(flood.route(0, 0xFE, 60), channels({1, 3}), Via::unknown);
    Net drop{settings([](auto& s) { s.unknown = Unknown::drop; })};
    expect(drop.route(0, 0xFE, 60), {}, Via::nobody);
    Net one{settings([](auto& s) { s.unknown = Unknown::link; })};
    one->set_unknown_link(link(2));
    expect(one.route(0, 0xFE, 60), channels({2}), Via::unknown);
    expect(one.route(2, 0xFE, 60), {}, Via::unknown);
    one->close(channel(2));
    expect(one.route(0, 0xFE, 60), {}, Via::unknown, links({2}));
}

TEST(Router, sources_0x00_and_0xFF_teach_nothing) {
    Net net;
    net.route(1, 0x00, 0xFE);
    net.route(1, 0xFF, 0xFE);
    EXPECT_EQ(net->learned(0x00, net.now).links, LinkSet{});
    EXPECT_EQ(net->learned(0xFF, net.now).links, LinkSet{});
    net->pin(0, 0, link(2));
    expect(net.route(0, 0xFE, 0x00), {}, Via::nobody);
    EXPECT_EQ(net->learned(0xFE, net.now).links, links({0}));    // its source is learned nevertheless
}

TEST(Router, frames_for_the_id_of_the_gateway_are_not_forwarded) {
    Net net{settings([](auto& s) { s.id = 199; })};
    net->pin(199, 199, link(2));
    expect(net.route(0, 0xFE, 199), {}, Via::own);
    EXPECT_EQ(net->own_frames(), 1u);
    EXPECT_EQ(net.route(0, 0xFE, 0x00).via, Via::nobody);
    EXPECT_EQ(net->own_frames(), 1u);
}

TEST(Router, frames_sent_to_several_links_are_guarded) {
    Net net{{}, {{}, {.group = 1}, {.group = 1}, {}}};
    net.route(1, 0xDC, 0xFE);
    EXPECT_EQ(net.route(0, 0xFE, 0xFF).guarded, channels({1, 2, 3}));
    EXPECT_EQ(net.route(0, 0xFE, 60).guarded, channels({1, 2, 3}));
    EXPECT_EQ(net.route(0, 0xFE, 0xDC).guarded, ChannelSet{});
    net.route(3, 0xFE, 0xFF);
    EXPECT_EQ(net.route(1, 0xDC, 0xFE).guarded, channels({0, 3})) << "two hosts";
}

TEST(Router, a_host_on_the_only_other_channel_needs_no_guard_after_the_third_closes) {
    Net net{{}, {{}, {}, {}}};
    net.route(1, 0xFE, 0xFF);
    EXPECT_EQ(net.route(0, 0xDC, 0xFE).guarded, channels({1}));
    net->close(channel(2));
    EXPECT_EQ(net.route(0, 0xDC, 0xFE).guarded, ChannelSet{});
}

}    // namespace
}    // namespace router_tests
