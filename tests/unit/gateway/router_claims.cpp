#include "routing_net.hpp"

using namespace routing;

namespace router_claims_tests {
namespace {

TEST(Router, device_that_moved_is_followed_after_three_seconds_of_silence) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    net.now += 60s;    // expired, but asked nevertheless
    net.route(2, 0xDC, 0xFF);
    const TimePoint claimed = net.now;
    for (int question = 0; question < 3; ++question) {
        EXPECT_EQ(net.asked(), (std::vector<std::pair<int, ChannelSet>>{{0xDC, channels({1})}}));
        EXPECT_TRUE(net.asked().empty());
        EXPECT_EQ(net->learned(0xDC, net.now).links, LinkSet{});
        EXPECT_EQ(net.route(2, 0xDC, 0xFF).channels, channels({0, 1, 3})) << "what it says passes";
        net.now = net->next_question().value();
    }
    EXPECT_EQ(net.now, claimed + 3s);
    EXPECT_TRUE(net.asked().empty());
    EXPECT_FALSE(net->next_question());
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);
    EXPECT_TRUE(net->conflicts(net.now).empty());
}

TEST(Router, reports_a_move_to_another_link_and_stores_the_previous_link) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    EXPECT_FALSE(net->pop_move());
    net.route(2, 0xDC, 0xFF);
    EXPECT_FALSE(net->pop_move()) << "it is tested yet";
    net.silence();
    auto moved = net->pop_move();
    ASSERT_TRUE(moved);
    EXPECT_EQ(moved->address, 0xDC);
    EXPECT_EQ(moved->from, links({1}));
    EXPECT_EQ(moved->to, link(2));
    EXPECT_FALSE(net->pop_move());
    EXPECT_EQ(net->moved_from(0xDC), links({1}));
    net.now += 10s;
    net.route(1, 0xDC, 0xFF);    // it has returned
    moved = net->pop_move();
    ASSERT_TRUE(moved);
    EXPECT_EQ(moved->to, link(1));
    EXPECT_EQ(net->moved_from(0xDC), LinkSet{});
    net->close(channel(1));
    net.route(3, 0xDC, 0xFF);
    moved = net->pop_move();
    ASSERT_TRUE(moved) << "its wire was gone";
    EXPECT_EQ(moved->from, links({1}));
    net->went_down(channel(3));
    net.route(2, 0xDC, 0xFF);
    EXPECT_TRUE(net->pop_move()) << "another wire was pulled";
    EXPECT_EQ(net->moved_from(0xDC), links({1}));
}

TEST(Router, address_stays_with_its_holder_until_silence) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    net.route(2, 0xDC, 0xFF);
    EXPECT_EQ(net.asked().size(), 1u);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net.now += 2900ms;
    net.asked();
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    EXPECT_FALSE(net->claims(0xDC, channel(1)));
    EXPECT_TRUE(net->claims(0xDC, channel(2)) && net->holds(0xDC, channel(1)) && !net->holds(0xDC, channel(2)));
    EXPECT_FALSE(net->claims(0xFE, channel(2)) || net->claims(0x00, channel(2)) || net->claims(0xFF, channel(2)));
}

TEST(Router, rejects_a_claim_on_any_frame_from_the_old_channel) {
    for (const bool goes_on : {true, false}) {
        Net net;
        net.route(1, 0xDC, 0xFF);
        net.route(2, 0xDC, 0xFF);
        net.asked();
        net.now += 1s;
        EXPECT_FALSE(net->heard_again(channel(2), 0xDC, net.now)) << "not of its own";
        if (goes_on) net.route(1, 0xDC, 0xFE);
        else EXPECT_TRUE(net->heard_again(channel(1), 0xDC, net.now));
        EXPECT_FALSE(net->next_question());
        ASSERT_EQ(net->conflicts(net.now).size(), 1u);
        EXPECT_EQ(net->conflicts(net.now)[0].links, links({1, 2}));
        EXPECT_EQ(net->conflicts(net.now)[0].count, 1u);
        EXPECT_TRUE(net->conflicts(net.now)[0].claimed);
        Router::Claimant claimant;
        ASSERT_TRUE(net->pop_claimant(claimant));
        EXPECT_EQ(claimant.address, 0xDC);
        EXPECT_EQ(claimant.channel, channel(2));
        EXPECT_FALSE(net->pop_claimant(claimant));
        net.now += 20s;
        expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    }
}

TEST(Router, tests_an_address_at_most_once_in_ten_seconds) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    net.route(1, 0xDD, 0xFF);
    const TimePoint begin = net.now;
    std::vector<TimePoint> tests;
    for (unsigned n = 0; net.now < begin + 35s; net.now += 100ms) {
        net.route(2 + n++ % 2, 0xDC, 0xFF);
        if (!net.asked().empty()) tests.push_back(net.now);
        net.route(1, 0xDC, 0xFF);
        EXPECT_TRUE(net.asked().empty());
    }
    EXPECT_EQ(tests, (std::vector<TimePoint>{begin, begin + 10s, begin + 20s, begin + 30s}));
    EXPECT_EQ(net->conflicts(net.now)[0].count, 4u);
    net.route(2, 0xDD, 0xFF);
    EXPECT_EQ(net.asked().size(), 1u) << "of another address at any time";
}

// 40 commands in 40 s; the attacker sends ten times a second, the device every 4 s and when it is asked.
TEST(Router, a_device_that_sends_only_every_4_s_keeps_its_address) {
    Net net;
    int reached = 0, stolen = 0;
    for (int tenth = 0; tenth < 400; ++tenth, net.now += 100ms) {
        if (tenth % 40 == 0) net.route(1, 0xDC, 0xFF);
        net.route(2, 0xDC, 0xFF);
        for (const auto& [address, by] : net.asked())
            if (by.contains(channel(1))) net.route(1, 0xDC, 0xFE);
        if (tenth % 10 != 0) continue;
        const ChannelSet to = net.route(0, 0xFE, 0xDC).channels;
        reached += to.contains(channel(1));
        stolen += to.contains(channel(2));
    }
    EXPECT_EQ(reached, 40);
    EXPECT_EQ(stolen, 0);
}

// It answers nothing and sends every 4 s, so that its silence is long enough.
TEST(Router, an_address_returns_at_once_when_its_first_channel_sends_again) {
    Net net;
    int reached = 0, stolen = 0;
    for (unsigned tenth = 0; tenth < 400; ++tenth, net.now += 100ms) {
        if (tenth % 40 == 0) net.route(1, 0xDC, 0xFF);
        net.route(2 + tenth / 100 % 2, 0xDC, 0xFF);    // alternating between two ports
        net.asked();
        if (tenth % 10 != 0) continue;
        const ChannelSet to = net.route(0, 0xFE, 0xDC).channels;
        reached += to.contains(channel(1));
        stolen += !to.contains(channel(1));
    }
    EXPECT_EQ(reached, 38);
    EXPECT_EQ(stolen, 2) << "a second after each silence";
    EXPECT_EQ(net->conflicts(net.now).at(0).links, links({1, 2, 3}));
}

TEST(Router, a_return_to_the_home_channel_is_no_conflict) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    net.route(2, 0xDC, 0xFF);
    net.silence();
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);
    net.now += 3s;
    net.route(1, 0xDC, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    EXPECT_TRUE(net->conflicts(net.now).empty());
    net.route(2, 0xDC, 0xFF);
    EXPECT_TRUE(net->claims(0xDC, channel(2))) << "it was second";
}

// A constant broadcast that another sender repeats is dropped by the loop guard.
TEST(Router, a_frame_that_the_loop_guard_drops_also_returns_an_address_to_its_home) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    EXPECT_TRUE(net->holds(0xDC, channel(1)));
    net.route(2, 0xDC, 0xFF);
    EXPECT_FALSE(net->holds(0xDC, channel(2)));
    net.silence();
    net.route(2, 0xDC, 0xFF);
    EXPECT_FALSE(net->holds(0xDC, channel(1)));
    EXPECT_FALSE(net->heard_again(channel(3), 0xDC, net.now));
    EXPECT_TRUE(net->heard_again(channel(1), 0xDC, net.now));
    EXPECT_TRUE(net->holds(0xDC, channel(1)));
    Router::Claimant claimant;
    ASSERT_TRUE(net->pop_claimant(claimant));
    EXPECT_EQ(claimant.channel, channel(2));
}

// Two cables of one device without `group`: the first breaks just after a test found the device there.
TEST(Router, second_cable_takes_over_within_thirteen_seconds) {
    Net net;
    for (const unsigned cable : {1u, 2u, 1u}) {
        net.route(cable, 0xDC, 0xFF);
        net.asked();
    }
    const TimePoint broke = net.now;
    while (net.route(0, 0xFE, 0xDC).channels != channels({2}) && net.now < broke + 60s) {
        net.now += 100ms;
        net.route(2, 0xDC, 0xFF);
        net.asked();
    }
    EXPECT_EQ(net.now - broke, 13s);
}

TEST(Router, treats_a_channel_that_is_down_or_closed_as_silent_at_once) {
    for (const bool closed : {false, true}) {
        for (const bool before : {false, true}) {
            Net net;
            net.route(1, 0xDC, 0xFF);
            if (!before) net.route(2, 0xDC, 0xFF);
            closed ? net->close(channel(1)) : net->went_down(channel(1));
            if (before) net.route(2, 0xDC, 0xFF);
            EXPECT_TRUE(net.asked().empty());
            EXPECT_FALSE(net->next_question());
            expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);
            EXPECT_TRUE(net->conflicts(net.now).empty()) << "plugged into another port";
            if (closed) continue;
            net->came_up(channel(1));
            net.route(1, 0xDC, 0xFF);
            expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
            EXPECT_EQ(net->conflicts(net.now).size(), 1u) << "both spoke just now";
        }
    }
}

TEST(Router, claim_ends_with_its_channel) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    net.route(2, 0xDC, 0xFF);
    net.asked();
    net->close(channel(2));
    EXPECT_FALSE(net->next_question());
    net->open(channel(2), link(2));
    net.silence();
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
}

TEST(Router, peers_of_one_link_are_different_locations) {
    Net net;
    net->open(channel(10), link(1));
    net.route(1, 0xDC, 0xFF);
    net.route(10, 0xDC, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net.silence();
    expect(net.route(0, 0xFE, 0xDC), channels({10}), Via::learned);
}

TEST(Router, rejects_claims_to_a_pinned_address_without_a_test) {
    Net net;
    net->pin(30, 30, link(1));
    net.route(3, 30, 0xFF);
    EXPECT_FALSE(net->next_question());
    ASSERT_EQ(net->conflicts(net.now).size(), 1u);
    EXPECT_EQ(net->conflicts(net.now)[0].links, links({1, 3}));
    net.route(1, 30, 0xFF);
    net.now += 60s;
    net.route(2, 30, 0xFF);
    net.silence();
    expect(net.route(0, 0xFE, 30), channels({1}), Via::pinned);
    EXPECT_TRUE(net->holds(30, channel(1)) && net->claims(30, channel(2)));
    EXPECT_FALSE(net->holds(31, channel(1)));
}

// A link with several channels, 1, 10 and 11: independent peers.
struct PinnedNet : Net {
    PinnedNet() {
        router->open(channel(10), link(1));
        router->open(channel(11), link(1));
        router->pin(30, 30, link(1));
    }
};

TEST(Router, a_pinned_address_has_its_home_on_the_first_channel_of_its_link_that_received_it) {
    PinnedNet net;
    EXPECT_TRUE(net->holds(30, channel(1)) && net->holds(30, channel(10))) << "nobody was heard";
    expect(net.route(0, 0xFE, 30), channels({1, 10, 11}), Via::pinned);
    net.route(10, 30, 0xFF);
    EXPECT_TRUE(net->holds(30, channel(10)) && !net->claims(30, channel(10)));
    EXPECT_TRUE(net->claims(30, channel(11)) && !net->holds(30, channel(11)));
    expect(net.route(0, 0xFE, 30), channels({10}), Via::pinned);
    expect(net->find(link(0), 30, net.now, ano::Intent::acts), channels({10}), Via::pinned);
    net.now += 60s;
    expect(net.route(0, 0xFE, 30), channels({10}), Via::pinned);
    net->close(channel(10));
    expect(net.route(0, 0xFE, 30), channels({1, 11}), Via::pinned);
    EXPECT_TRUE(net->holds(30, channel(11)));
}

TEST(Router, a_pinned_address_stays_with_its_channel_while_that_sends) {
    PinnedNet net;
    net.route(10, 30, 0xFF);
    net.route(11, 30, 0xFF);
    EXPECT_EQ(net.asked(), (std::vector<std::pair<int, ChannelSet>>{{30, channels({10})}}));
    net.route(10, 30, 0xFF);
    EXPECT_FALSE(net->next_question());
    ASSERT_EQ(net->conflicts(net.now).size(), 1u);
    EXPECT_EQ(net->conflicts(net.now)[0].links, links({1}));
    Router::Claimant claimant;
    ASSERT_TRUE(net->pop_claimant(claimant));
    EXPECT_EQ(claimant.channel, channel(11));
    expect(net.route(0, 0xFE, 30), channels({10}), Via::pinned);
}

TEST(Router, a_pinned_address_moves_within_its_link_if_its_channel_is_silent_and_returns) {
    PinnedNet net;
    net.route(10, 30, 0xFF);
    net.route(11, 30, 0xFF);
    net.silence();
    expect(net.route(0, 0xFE, 30), channels({11}), Via::pinned);
    EXPECT_TRUE(net->claims(30, channel(1)) && !net->claims(30, channel(10))) << "it was there first";
    EXPECT_TRUE(net->conflicts(net.now).empty());
    EXPECT_FALSE(net->pop_move()) << "it is on the same link";
    net.now += 10s;
    net.route(10, 30, 0xFF);
    expect(net.route(0, 0xFE, 30), channels({10}), Via::pinned);
    net->went_down(channel(10));
    net.route(1, 30, 0xFF);
    expect(net.route(0, 0xFE, 30), channels({1}), Via::pinned);
}

// Otherwise claims from elsewhere would prevent the device from moving, or be accepted with its move.
TEST(Router, claims_from_other_links_do_not_move_a_pinned_address_within_its_link) {
    PinnedNet net;
    net.route(10, 30, 0xFF);
    for (int i = 0; i < 30; ++i) {
        net.route(3, 30, 0xFF);
        net.now += 1s;
    }
    ASSERT_EQ(net->conflicts(net.now).size(), 1u);
    EXPECT_EQ(net->conflicts(net.now)[0].count, 3u) << "one in 10 s";
    net.route(3, 30, 0xFF);
    net.route(11, 30, 0xFF);
    EXPECT_EQ(net.asked(), (std::vector<std::pair<int, ChannelSet>>{{30, channels({10})}}));
    net.route(3, 30, 0xFF);
    net.silence();
    expect(net.route(0, 0xFE, 30), channels({11}), Via::pinned);
    EXPECT_TRUE(net->claims(30, channel(3)));
}

TEST(Router, an_address_pinned_to_two_links_has_a_home_channel_on_each) {
    PinnedNet net;
    net->pin(30, 30, link(2));
    net->open(channel(12), link(2));
    net.route(10, 30, 0xFF);
    expect(net.route(0, 0xFE, 30), channels({2, 10, 12}), Via::pinned);
    net.route(12, 30, 0xFF);
    EXPECT_FALSE(net->next_question());
    expect(net.route(0, 0xFE, 30), channels({10, 12}), Via::pinned);
    EXPECT_TRUE(net->claims(30, channel(2)) && net->claims(30, channel(11)));
    net.route(11, 30, 0xFF);
    EXPECT_EQ(net.asked(), (std::vector<std::pair<int, ChannelSet>>{{30, channels({10})}}));
    net.route(12, 30, 0xFF);    // proves nothing about the other link
    net.silence();
    expect(net.route(0, 0xFE, 30), channels({11, 12}), Via::pinned);
}

TEST(Router, a_running_claim_test_ends_when_the_address_is_pinned) {
    Net net;
    net.route(1, 30, 0xFF);
    net.route(3, 30, 0xFF);
    net->pin(30, 30, link(1));
    net.silence();
    expect(net.route(0, 0xFE, 30), channels({1}), Via::pinned);
    EXPECT_TRUE(net->claims(30, channel(3)));
    EXPECT_FALSE(net->pop_move());
}

TEST(Router, pinned_host_is_reached_by_every_channel_of_its_link) {
    PinnedNet net;
    net->pin(0xFE, 0xFE, link(1));
    net.route(10, 0xFE, 0xFF);
    expect(net.route(0, 0xDC, 0xFE), channels({1, 10, 11}), Via::pinned);
    EXPECT_FALSE(net->claims(0xFE, channel(11)));
}

}    // namespace
}    // namespace router_claims_tests
