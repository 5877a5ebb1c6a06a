// Frames that act on a device, for addresses that were not heard recently; frames for hosts that were never heard.
#include "routing_net.hpp"

namespace router_acts_tests {

using namespace routing;

namespace {

constexpr std::uint8_t host = 0xFE, unknown = 0x44, old = 0x01;

struct Acts : testing::Test {
    Route act(unsigned from, std::uint8_t destination, std::uint8_t source = host) {
        return net->route(channel(from), source, destination, net.now, ano::Intent::acts);
    }
    void receive(unsigned from, std::uint8_t source) { net.route(from, source, 0xFF); }
    Net net;
};

TEST_F(Acts, for_an_unknown_address_are_not_sent_to_other_devices) {
    receive(1, old);
    receive(2, 0xDC);
    expect(act(0, unknown), channels({3}), Via::unknown);
    expect(net->find(link(0), unknown, net.now, ano::Intent::acts), channels({0, 3}), Via::unknown);
    expect(net->route(channel(0), host, unknown, net.now, ano::Intent::asks), channels({1, 2, 3}), Via::unknown);
    expect(act(0, old), channels({1}), Via::learned);
}

// A link is recreated with other settings: the homes of devices on it are restored for frames that act.
TEST_F(Acts, are_sent_to_the_last_home_on_a_recreated_link) {
    receive(1, old);
    receive(2, 0xDC);
    const auto homes = net->last_homes(link(2));
    EXPECT_EQ(homes.count(), 1u);
    net->close(channel(2));
    EXPECT_EQ(net->last_homes(link(2)), homes);
    net->remove_link(link(2));
    expect(act(0, 0xDC), channels({1, 3}), Via::unknown);
    const LinkId remade = net->add_link({});
    net->restore_last_homes(homes, remade);
    EXPECT_TRUE(act(0, 0xDC).channels.empty()) << "it is not open yet";
    net->open(channel(2), remade);
    expect(act(0, 0xDC), channels({2}), Via::learned);
    expect(act(0, unknown), channels({3}), Via::unknown);    // its silent device receives no frames for others
    receive(1, 0xDC);
    expect(act(0, 0xDC), channels({1}), Via::learned);
    expect(act(0, unknown), channels({1, 2, 3}), Via::unknown);
}

TEST_F(Acts, are_sent_to_the_only_channel_with_devices) {
    receive(1, old);
    expect(act(0, unknown), channels({1, 2, 3}), Via::unknown);
    receive(1, 0x02);
    expect(act(0, unknown), channels({1, 2, 3}), Via::unknown);
    expect(act(3, unknown, 0x30), channels({0, 2}), Via::unknown);    // a device: its own channel has devices as well
}

// The address may be on a link that was never heard: its port is absent, or its devices send only answers.
TEST_F(Acts, are_not_sent_to_other_devices_while_the_address_may_be_elsewhere) {
    net->close(channel(2));
    net->remove_link(link(2));
    const LinkId other = net->add_link({.may_have_devices = true});
    receive(1, old);
    EXPECT_FALSE(act(0, unknown).channels.contains(channel(1))) << "it is down";
    net->open(channel(2), other);
    expect(act(0, unknown), channels({2, 3}), Via::unknown);
    receive(2, host);
    expect(act(0, unknown), channels({1, 2, 3}), Via::unknown);
}

TEST_F(Acts, are_also_sent_to_channels_with_hosts) {
    receive(1, old);
    receive(2, 0xDC);
    receive(2, host);
    expect(act(0, unknown), channels({2, 3}), Via::unknown);
    net->note_host(channel(1));
    expect(act(0, unknown), channels({1, 2, 3}), Via::unknown);
}

TEST_F(Acts, are_not_sent_to_the_only_link_if_its_device_acts_for_other_addresses) {
    Net one{{}, {{}, {.acts_for_others = true}}};
    one.route(1, old, 0xFF);
    expect(one->route(channel(0), host, unknown, one.now, ano::Intent::acts), {}, Via::unknown);
    expect(one->route(channel(0), host, old, one.now, ano::Intent::acts), channels({1}), Via::learned);
}

// It answered for an address that is not its own.
TEST_F(Acts, are_not_sent_to_the_only_link_once_its_device_is_known_to_act_for_other_addresses) {
    receive(1, old);
    expect(act(0, unknown), channels({1, 2, 3}), Via::unknown);
    net->note_acts_for_others(link(1));
    expect(act(0, unknown), channels({2, 3}), Via::unknown);
    expect(act(0, old), channels({1}), Via::learned);
}

TEST_F(Acts, all_links_of_a_group_count_as_one_location) {
    Net grouped{{}, {{}, {.group = 1}, {.group = 1}, {}}};
    grouped.route(1, old, 0xFF);
    grouped.now += 2s;
    expect(grouped->route(channel(0), host, unknown, grouped.now, ano::Intent::acts), channels({1, 2, 3}), Via::unknown);
    grouped.route(3, 0xDC, 0xFF);
    expect(grouped->route(channel(0), host, unknown, grouped.now, ano::Intent::acts), {}, Via::unknown);
    grouped.route(2, host, 0xDC);
    grouped.now += 2s;
    expect(grouped->route(channel(0), host, unknown, grouped.now, ano::Intent::acts), channels({1, 2}), Via::unknown);
}

TEST_F(Acts, the_peers_of_a_link_count_as_several_locations) {
    Net peers{{}, {{}, {}}};
    peers->open(channel(2), link(1));
    peers.route(1, old, 0xFF);
    peers.route(2, 0xDC, 0xFF);
    expect(peers->route(channel(0), host, unknown, peers.now, ano::Intent::acts), {}, Via::unknown);
}

TEST_F(Acts, for_an_expired_address_are_sent_where_it_was_last_seen) {
    receive(1, old);
    receive(2, 0xDC);
    receive(3, unknown);
    net.now += 1h;
    expect(act(0, unknown), channels({3}), Via::learned);
    expect(net.route(0, host, unknown), channels({1, 2, 3}), Via::unknown);
    EXPECT_TRUE(net->learned(unknown, net.now).links.empty());
    net->forget(unknown);
    expect(act(0, unknown), channels({3}), Via::unknown);    // no device is there any more
}

TEST_F(Acts, for_an_address_whose_channel_is_closed_are_sent_to_its_link) {
    receive(1, old);
    receive(2, 0xDC);
    receive(3, unknown);
    net->close(channel(3));
    expect(act(0, unknown), {}, Via::learned, links({3}));
    net->open(channel(3), link(3));
    expect(act(0, unknown), channels({3}), Via::learned);
    receive(3, 0x05);
    expect(act(0, unknown), {}, Via::learned);
    receive(3, unknown);
    expect(act(0, unknown), channels({3}), Via::learned);
    net->close(channel(3));
    net->remove_link(link(3));
    expect(act(0, unknown), {}, Via::unknown);
}

TEST_F(Acts, follow_a_configured_rule_for_unknown_addresses) {
    Net to_link{settings([](GatewaySettings& s) { s.unknown = Unknown::link; })};
    to_link->set_unknown_link(link(1));
    to_link.route(1, old, 0xFF);
    to_link.route(2, 0xDC, 0xFF);
    expect(to_link->route(channel(0), host, unknown, to_link.now, ano::Intent::acts), channels({1}), Via::unknown);
    Net dropped{settings([](GatewaySettings& s) { s.unknown = Unknown::drop; })};
    dropped.route(1, old, 0xFF);
    expect(dropped->route(channel(0), host, unknown, dropped.now, ano::Intent::acts), {}, Via::nobody);
    dropped.now += 1h;
    expect(dropped->route(channel(0), host, old, dropped.now, ano::Intent::acts), channels({1}), Via::learned);
}

TEST_F(Acts, frames_for_hosts_not_seen_yet_are_not_sent_to_channels_with_devices_only) {
    receive(0, 0xDC);
    receive(1, old);
    for (const std::uint8_t to : {host, ano::address::ros_bridge}) expect(net.route(0, 0xDC, to), channels({2, 3}), Via::unknown);
    receive(1, 0xD2);
    expect(net.route(0, 0xDC, host), channels({1, 2, 3}), Via::unknown);
    net->note_host(channel(0));
    expect(net.route(1, old, host), channels({0, 2, 3}), Via::unknown);
}

TEST_F(Acts, a_frame_for_a_host_that_is_down_is_not_sent_to_channels_with_devices_only) {
    receive(0, 0xDC);
    receive(1, old);
    receive(2, host);
    net->went_down(channel(2));
    expect(net.route(0, 0xDC, host), channels({2, 3}), Via::unknown);
}

TEST_F(Acts, are_sent_to_the_channel_that_the_only_device_there_has_left) {
    receive(1, old);
    receive(2, 0xDC);
    net->went_down(channel(1));
    receive(3, old);
    net->came_up(channel(1));
    expect(act(0, unknown), channels({1}), Via::unknown);
}

TEST_F(Acts, a_device_is_alone_if_its_channel_has_no_other_device_or_host) {
    receive(1, old);
    EXPECT_TRUE(net->is_alone(old, channel(1)));
    EXPECT_FALSE(net->is_alone(old, channel(2)));
    receive(1, 0x02);
    EXPECT_FALSE(net->is_alone(old, channel(1)));
    receive(2, 0xDC);
    net->note_host(channel(2));
    EXPECT_FALSE(net->is_alone(0xDC, channel(2)));
}

// A host and a device with the same address: one sends to the other.
TEST_F(Acts, a_frame_with_equal_source_and_destination_is_sent_to_the_other_holder_of_the_address) {
    receive(1, old);
    expect(act(0, old, old), channels({1}), Via::learned);
    EXPECT_EQ(net.asked().size(), 1u) << "the host claims the address";
    receive(1, old);
    expect(net.route(1, old, old), channels({0}), Via::learned);
    net->close(channel(0));
    expect(net.route(1, old, old), channels({2, 3}), Via::unknown);
}

TEST_F(Acts, a_frame_with_equal_source_and_destination_has_an_unknown_target_if_only_the_host_was_seen) {
    receive(2, 0xDC);
    receive(3, 0xDD);
    expect(act(0, old, old), channels({1}), Via::unknown);
    receive(1, old);
    expect(act(0, old, old), channels({1}), Via::learned);
    expect(net.route(1, old, old), channels({0}), Via::learned);
    net->pin(old, old, link(1));
    expect(net.route(1, old, old), channels({0}), Via::pinned);
}

}    // namespace
}    // namespace router_acts_tests
