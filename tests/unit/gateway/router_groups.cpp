#include "routing_net.hpp"

using namespace routing;

namespace router_groups_tests {
namespace {

// Links 1 and 2 lead to the same network.
struct GroupedRouter : testing::Test {
    Net net{{}, {{}, {.group = 1}, {.group = 1}, {}}};
};

TEST_F(GroupedRouter, sends_by_the_member_that_received_most_recently) {
    net.route(1, 0xDC, 0xFE);
    net.now += 10ms;
    net.route(2, 0xDD, 0xFE);
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);
    expect(net.route(0, 0xFE, 0xFF), channels({2, 3}), Via::broadcast);
    expect(net.route(0, 0xFE, 60), channels({2, 3}), Via::unknown);
    net.now += 10ms;
    net.route(1, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 0xDD), channels({1}), Via::learned);
    net->pin(40, 40, link(1));
    net->pin(40, 40, link(2));
    expect(net.route(0, 0xFE, 40), channels({1}), Via::pinned);
}

TEST_F(GroupedRouter, never_sends_frames_back_by_the_group_of_their_source_except_to_other_peers) {
    net.route(1, 0xDC, 0xFE);
    net.route(2, 0xDD, 0xFE);
    expect(net.route(1, 0xDC, 0xFF), channels({0, 3}), Via::broadcast);
    expect(net.route(1, 0xDC, 0xDD), {}, Via::learned);
    net->open(channel(10), link(1));
    expect(net.route(1, 0xDC, 0xFF), channels({0, 3, 10}), Via::broadcast);    // but to another peer of the link
}

TEST_F(GroupedRouter, sends_to_all_members_until_one_has_received_a_frame) {
    expect(net.route(0, 0xFE, 0xFF), channels({1, 2, 3}), Via::broadcast);
    net.route(2, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 0xFF), channels({2, 3}), Via::broadcast);
    net.now += Router::group_silence;
    expect(net.route(0, 0xFE, 0xFF), channels({1, 2, 3}), Via::broadcast);
    expect(net.route(0, 0xFE, 0xDC), channels({1, 2}), Via::learned);
}

// Links 1 and 2 lead to a device that would execute a command once for each link.
TEST(Router, a_command_to_a_silent_group_whose_devices_recognise_no_copies_is_sent_on_one_link) {
    Net net{{}, {{}, {.group = 1, .drops_copies = false}, {.group = 1, .drops_copies = false}, {}}};
    net.route(2, 0xDC, 0xFE);
    net.now += Router::group_silence;
    for (const std::uint8_t to : {std::uint8_t{0xDC}, std::uint8_t{0xFF}, std::uint8_t{60}}) {
        const Route route = net->route(channel(0), 0xFE, to, net.now, ano::Intent::acts);
        EXPECT_EQ((route.channels & channels({1, 2})), channels({2})) << int{to};
    }
    EXPECT_EQ(net->route(channel(0), 0xFE, 0xDC, net.now, ano::Intent::asks).channels, channels({1, 2})) << "both may answer";
    net->went_down(channel(2));
    EXPECT_EQ(net->route(channel(0), 0xFE, 0xDC, net.now, ano::Intent::acts).channels, channels({1}));
}

TEST_F(GroupedRouter, skips_a_member_that_is_down) {
    net.route(2, 0xDC, 0xFE);
    net->went_down(channel(2));
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net->went_down(channel(1));
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);    // counted link_down, once
    net->came_up(channel(1));
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net->came_up(channel(2));
    expect(net.route(0, 0xFE, 0xDC), channels({1, 2}), Via::learned);    // nothing was received since
    net.route(2, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);
    net->report_unreachable(link(2));
    expect(net.route(0, 0xFE, 0xDC), channels({1, 2}), Via::learned);
}

TEST_F(GroupedRouter, a_member_that_was_disconnected_for_a_moment_is_chosen_once_it_has_received_a_frame_again) {
    net.route(1, 0xDC, 0xFE);
    net.now += 10ms;
    net.route(2, 0xDC, 0xFE);
    net->went_down(channel(2));
    net->came_up(channel(2));
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net.route(2, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);
}

TEST_F(GroupedRouter, a_member_knows_whether_another_one_is_connected) {
    EXPECT_TRUE(net->has_connected_mate(channel(1)));
    net->went_down(channel(2));
    EXPECT_FALSE(net->has_connected_mate(channel(1)));
    EXPECT_TRUE(net->has_connected_mate(channel(2)));
    EXPECT_FALSE(net->has_connected_mate(channel(0))) << "it has no group";
    net->came_up(channel(2));
    net->leave_group(channel(2));
    EXPECT_FALSE(net->has_connected_mate(channel(1)));
}

TEST_F(GroupedRouter, a_member_without_a_channel_is_not_reported_as_missing_while_another_has_one) {
    net->close(channel(1));
    net->pin(40, 40, link(1));
    net.route(2, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 40), channels({2}), Via::pinned);
    net->close(channel(2));
    expect(net.route(0, 0xFE, 40), {}, Via::pinned, links({1}));
}

TEST_F(GroupedRouter, one_source_on_two_members_is_no_conflict) {
    net.route(1, 0xDC, 0xFE);
    net.route(2, 0xDC, 0xFE);
    net.route(1, 0xDC, 0xFE);
    EXPECT_TRUE(net->conflicts(net.now).empty());
    net.route(3, 0xDC, 0xFE);
    EXPECT_EQ(net.asked(), (std::vector<std::pair<int, ChannelSet>>{{0xDC, channels({1, 2})}}));
    net.route(2, 0xDC, 0xFE);
    ASSERT_EQ(net->conflicts(net.now).size(), 1u);
    EXPECT_TRUE(net->conflicts(net.now)[0].links.contains(link(3)));
}

TEST(Router, a_frame_for_the_port_id_of_a_group_member_is_sent_to_that_port) {
    Net net{{}, {{}, {.port_id = 5, .group = 1}, {.port_id = 6, .group = 1}}};
    net.route(2, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 5), channels({1}), Via::port);
}

TEST(Router, broadcasts_are_not_sent_to_group_members_without_the_broadcast_setting) {
    Net net{{}, {{}, {.broadcast = false, .group = 1}, {.group = 1}}};
    net.route(1, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 0xFF), channels({2}), Via::broadcast);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
}

// Link 1 is a radio at a serial port, link 2 listens; its peers 2 and 10 are trusted, 11 and 12 are not.
struct ListeningMember : testing::Test {
    ListeningMember() {
        for (const unsigned peer : {10u, 11u, 12u}) net->open(channel(peer), link(2));
        for (const unsigned stranger : {11u, 12u}) net->leave_group(channel(stranger));
    }
    Net net{{}, {{}, {.group = 1}, {.group = 1}, {}}};
    const std::vector<std::pair<int, ChannelSet>> only_the_radio{{0xDC, channels({1})}};
};

TEST_F(ListeningMember, of_a_group_has_one_home_of_a_device) {
    net.route(1, 0xDC, 0xFF);
    net.route(2, 0xDC, 0xFF);
    EXPECT_FALSE(net->claims(0xDC, channel(1)));
    EXPECT_FALSE(net->claims(0xDC, channel(2)));
    net.route(10, 0xDC, 0xFF);
    EXPECT_TRUE(net->claims(0xDC, channel(10)));
    EXPECT_EQ(net.asked(), (std::vector<std::pair<int, ChannelSet>>{{0xDC, channels({2})}}));
    net.silence();
    EXPECT_FALSE(net->claims(0xDC, channel(10)));
    EXPECT_FALSE(net->claims(0xDC, channel(1))) << "the other link of the group stays its home";
    EXPECT_FALSE(net->pop_move()) << "it is on the same links";
    net.route(10, 0xDC, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({10}), Via::learned);
}

TEST_F(ListeningMember, has_peers_that_are_not_in_the_group) {
    net.route(1, 0xDC, 0xFF);
    for (const unsigned stranger : {11u, 12u}) {
        net.now += 20s;
        net.route(1, 0xDC, 0xFF);
        net.route(stranger, 0xDC, 0xFF);
        EXPECT_TRUE(net->claims(0xDC, channel(stranger)));
        EXPECT_EQ(net.asked(), only_the_radio);
        net.route(1, 0xDC, 0xFF);
        EXPECT_EQ(net->conflicts(net.now).size(), 1u);
        expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
        EXPECT_TRUE(net->claims(0xDC, channel(stranger)));
    }
}

TEST_F(ListeningMember, receives_no_frames_instead_of_another_because_a_stranger_sent_last) {
    net.route(1, 0xDC, 0xFF);
    net.now += 10ms;
    net.route(11, 0x33, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    expect(net.route(0, 0xFE, 0xFF), channels({1, 3, 11, 12}), Via::broadcast);
    expect(net.route(11, 0x33, 0xFF), channels({0, 1, 3, 12}), Via::broadcast);
}

TEST_F(ListeningMember, never_replaces_a_pinned_radio_with_a_stranger) {
    net->pin(0xDC, 0xDC, link(1));
    for (const unsigned member : {2u, 10u}) net->close(channel(member));
    const auto expect_claim_refused = [&] {
        net.route(11, 0xDC, 0xFF);
        EXPECT_TRUE(net->claims(0xDC, channel(11)));
        EXPECT_FALSE(net->holds(0xDC, channel(11)));
        EXPECT_TRUE(net.asked().empty()) << "the pin answers the question";
        expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::pinned);
    };
    expect_claim_refused();
    net.route(1, 0xDC, 0xFF);
    net.now += 20s;
    expect_claim_refused();
    net->went_down(channel(1));
    expect_claim_refused();
    EXPECT_FALSE(net->pop_move());
}

TEST_F(ListeningMember, replaces_a_pinned_radio_at_once_with_a_trusted_peer) {
    net->pin(0xDC, 0xDC, link(1));
    net.route(1, 0xDC, 0xFF);
    net.route(2, 0xDC, 0xFF);
    EXPECT_FALSE(net->claims(0xDC, channel(2)));
    net.now += 10ms;
    net.route(2, 0xDC, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::pinned);
    net.route(10, 0xDC, 0xFF);
    EXPECT_TRUE(net->claims(0xDC, channel(10))) << "of two peers of the link, the first is its home";
}

TEST_F(ListeningMember, replaces_a_pinned_radio_that_is_down_with_a_trusted_peer) {
    net->pin(0xDC, 0xDC, link(1));
    net.route(1, 0xDC, 0xFF);
    net->went_down(channel(1));
    net.route(2, 0xDC, 0xFF);
    EXPECT_FALSE(net->claims(0xDC, channel(2)));
    net->came_up(channel(1));
    net.route(1, 0xDC, 0xFF);
    EXPECT_FALSE(net->claims(0xDC, channel(1)));
}

}    // namespace
}    // namespace router_groups_tests
