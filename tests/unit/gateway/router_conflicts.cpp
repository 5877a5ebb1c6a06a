#include "routing_net.hpp"

using namespace routing;

namespace router_conflicts_tests {
namespace {

TEST(Router, a_source_on_two_links_is_a_conflict_while_both_send) {
    Net net;
    Conflict conflict;
    const auto both = [&](unsigned a, unsigned b) {
        net.route(a, 0xDE, 0xFF);
        net.now += 100ms;
        net.route(b, 0xDE, 0xFF);
        net.now += 100ms;
    };
    both(1, 2);
    EXPECT_TRUE(net->conflicts(net.now).empty()) << "it may have moved";
    net.route(1, 0xDE, 0xFF);
    auto found = net->conflicts(net.now);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].address, 0xDE);
    EXPECT_EQ(found[0].links, links({1, 2}));
    ASSERT_TRUE(net->pop_new_conflict(conflict));
    EXPECT_EQ(conflict.address, 0xDE);
    const auto end = net.now + 60s;
    while (net.now < end) both(1, 2);
    net.route(1, 0xDE, 0xFF);
    EXPECT_FALSE(net->pop_new_conflict(conflict)) << "told once";
    net.now += 30s;
    EXPECT_TRUE(net->conflicts(net.now).empty());
    both(1, 3);
    net.route(1, 0xDE, 0xFF);
    ASSERT_TRUE(net->pop_new_conflict(conflict)) << "a new one is told again";
    EXPECT_EQ(conflict.links, links({1, 3}));
}

// If heard addresses expire before the next test may begin.
TEST(Router, conflict_lasts_as_long_as_the_claims) {
    Net net{settings([](auto& s) { s.forget_after = 2s; })};
    net.route(1, 0xDE, 0xFF);
    net.route(2, 0xDE, 0xFF);
    for (int i = 0; i < 200; ++i) {
        net.route(1, 0xDE, 0xFF);
        EXPECT_EQ(net->conflicts(net.now).size(), 1u);
        net.now += 100ms;
        net.route(2, 0xDE, 0xFF);
    }
}

TEST(Router, reports_every_new_conflict) {
    Net net;
    for (const std::uint8_t source : std::initializer_list<std::uint8_t>{0xDE, 0xDD, 0x20})
        for (const unsigned from : {1u, 2u, 1u}) net.route(from, source, 0xFF);
    Conflict conflict;
    std::vector<int> told;
    while (net->pop_new_conflict(conflict)) told.push_back(conflict.address);
    EXPECT_EQ(told, (std::vector<int>{0x20, 0xDD, 0xDE}));
}

TEST(Router, also_reports_the_second_of_two_new_conflicts) {
    Net net;
    net->note_conflict(0xDC, links({0, 1}), std::nullopt, net.now);
    net->note_conflict(0xDD, links({0, 1}), std::nullopt, net.now);
    Conflict conflict;
    ASSERT_TRUE(net->pop_new_conflict(conflict));
    EXPECT_TRUE(net.route(2, 0x10, 0xFF).new_conflict);
    ASSERT_TRUE(net->pop_new_conflict(conflict));
    EXPECT_EQ(conflict.address, 0xDD);
    EXPECT_FALSE(net.route(2, 0x10, 0xFF).new_conflict);
}

TEST(Router, also_forgets_the_conflict_of_a_forgotten_address) {
    Net net;
    net->note_conflict(0xDC, links({0, 1}), std::nullopt, net.now);
    net->note_conflict(0xDD, links({0, 1}), std::nullopt, net.now);
    net->forget(0xDC);
    const auto left = net->conflicts(net.now);
    ASSERT_EQ(left.size(), 1u);
    EXPECT_EQ(left[0].address, 0xDD);
}

TEST(Router, a_conflict_ends_with_one_of_its_two_links) {
    Net net;
    net->note_conflict(0xDC, links({1, 2}), std::nullopt, net.now);
    net->note_conflict(0xDD, links({1, 2, 3}), channel(3), net.now);
    net->note_conflict(0xDE, links({2}), std::nullopt, net.now);
    net->close(channel(2));
    net->remove_link(link(2));
    ASSERT_EQ(net->conflicts(net.now).size(), 1u);
    EXPECT_EQ(net->conflicts(net.now)[0].links, links({1, 3}));
    Conflict conflict;
    ASSERT_TRUE(net->pop_new_conflict(conflict));
    EXPECT_EQ(conflict.address, 0xDD);
    EXPECT_FALSE(net->pop_new_conflict(conflict)) << "of the others nothing is told";
}

}    // namespace
}    // namespace router_conflicts_tests
