#include "routing_net.hpp"

using namespace routing;

namespace router_changes_tests {
namespace {

TEST(Router, forgets_where_an_address_was_seen) {
    Net net;
    EXPECT_FALSE(net->forget(0xDC)) << "it was nowhere";
    net.route(0, 0xDC, 0xFE);
    net.route(1, 0xDC, 0xFE);    // a claim
    expect(net.route(2, 0xFE, 0xDC), channels({0}), Via::learned);
    EXPECT_TRUE(net->forget(0xDC));
    EXPECT_TRUE(net->learned(0xDC, net.now).links.empty());
    EXPECT_FALSE(net->has_question(net.now)) << "the claim is over";
    expect(net.route(2, 0xFE, 0xDC), channels({0, 1, 3}), Via::unknown);
    net.route(1, 0xDC, 0xFE);
    expect(net.route(2, 0xFE, 0xDC), channels({1}), Via::learned);
}

TEST(Router, restores_learned_routes_after_a_restart) {
    Net before, after;
    before.route(0, 0xDC, 0xFF);
    before.now += 10s;
    before.route(1, 0xFE, 0xFF);
    before.route(2, 0xFE, 0xFF);
    EXPECT_EQ(before.router->heard_at(0xDC, ChannelId{0}), before.now - 10s);
    EXPECT_EQ(before.router->heard_at(0xDC, ChannelId{1}), std::nullopt);
    after.now = before.now + 1s;
    for (unsigned a = 0; a < 256; ++a)
        for (unsigned c = 0; c < 4; ++c)
            if (const auto at = before.router->heard_at(static_cast<std::uint8_t>(a), static_cast<ChannelId>(c)))
                after.router->restore(static_cast<std::uint8_t>(a), static_cast<ChannelId>(c), *at);
    EXPECT_EQ(after.route(3, 0xFD, 0xDC).channels, ChannelSet{ChannelId{0}});
    EXPECT_EQ(after.route(3, 0xFD, 0xFE).channels, (ChannelSet{ChannelId{1}} | ChannelSet{ChannelId{2}}));
    EXPECT_EQ(after.router->learned(0xDC, after.now).last, before.now - 10s) << "no younger than it is";
    after.now += 20s;
    EXPECT_TRUE(after.router->learned(0xDC, after.now).links.empty()) << "30 s since it was heard";
}

TEST(Router, restores_the_age_of_a_learned_address) {
    Net net;
    net.now += 1min;
    net->restore(0xDC, channel(1), net.now - 10s);
    EXPECT_EQ(net->heard_at(0xDC, channel(1)), net.now - 10s);
}

TEST(Router, a_new_channel_inherits_nothing_from_a_closed_one_with_the_same_number) {
    Net net;
    net.route(1, 0xDC, 0xFE);
    net->went_down(channel(1));
    net.route(2, 0xDC, 0xFE);    // it moved
    net->restore_first(0xDC, channel(1));
    EXPECT_TRUE(net->was_first(0xDC, channel(1)));
    EXPECT_TRUE(net->are_all_down(channels({1})));
    net->close(channel(1));
    net->open(channel(1), link(1));
    EXPECT_FALSE(net->was_first(0xDC, channel(1)));
    EXPECT_FALSE(net->are_all_down(channels({1})));
}

TEST(Router, does_not_restore_addresses_0x00_and_0xFF) {
    Net net;
    net.router->restore(0x00, ChannelId{0}, net.now);
    net.router->restore(0xFF, ChannelId{0}, net.now);
    EXPECT_EQ(net.router->heard_at(0x00, ChannelId{0}), std::nullopt);
    EXPECT_EQ(net.router->heard_at(0xFF, ChannelId{0}), std::nullopt);
}

// The channel with the same number is closed first.
TEST(Router, a_new_link_inherits_nothing_from_a_removed_one_with_the_same_number) {
    Net net{{}, {{}, {.port_id = 5, .flood = false, .broadcast = false, .group = 1}, {.group = 1}, {}}};
    net->pin(40, 42, link(1));
    net->unpin(41, 41, link(1));
    net.route(1, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 42), channels({1}), Via::pinned);
    expect(net.route(0, 0xFE, 41), channels({2, 3}), Via::unknown);
    net->close(channel(1));
    net->remove_link(link(1));
    EXPECT_EQ(net->group(1), links({2}));
    for (const unsigned to : {5u, 40u, 42u, 0xDCu})
        expect(net.route(0, 0xFE, static_cast<std::uint8_t>(to)), channels({2, 3}), Via::unknown);
    ASSERT_EQ(net->add_link({}), link(1));
    net->open(channel(1), link(1));
    for (const unsigned to : {5u, 40u, 42u, 0xDCu})
        expect(net.route(0, 0xFE, static_cast<std::uint8_t>(to)), channels({1, 2, 3}), Via::unknown);
    net.route(1, 0xDD, 0xFE);
    expect(net.route(2, 0xDE, 0xDD), channels({1}), Via::learned);
}

TEST(Router, gives_a_new_link_the_lowest_free_number) {
    Net net;
    for (const unsigned n : {1u, 2u}) {
        net->close(channel(n));
        net->remove_link(link(n));
    }
    EXPECT_EQ(net->add_link({}), link(1));
    EXPECT_EQ(net->add_link({}), link(2));
    EXPECT_EQ(net->add_link({}), link(4));
}

}    // namespace
}    // namespace router_changes_tests
