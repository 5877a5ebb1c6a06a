#include <gateway/router.hpp>

#include <gtest/gtest.h>

#include <memory>

using namespace anogate;
using namespace std::chrono_literals;

namespace {

template <class Change>
GatewaySettings settings(Change change) {
    GatewaySettings result;
    change(result);
    return result;
}

// One channel a link and as many links as asked for, but for what a test adds itself.
struct Net {
    explicit Net(const GatewaySettings& gateway = {}, std::vector<Router::LinkRule> rules = {{}, {}, {}, {}})
        : router{std::make_unique<Router>(gateway)} {
        for (const auto& rule : rules) {
            const LinkId link = router->add_link(rule);
            router->open(static_cast<ChannelId>(index(link)), link);
        }
    }
    Route route(unsigned from, std::uint8_t source, std::uint8_t destination) {
        return router->route(static_cast<ChannelId>(from), source, destination, now);
    }
    /// Who is asked now, by which channels.
    std::vector<std::pair<int, ChannelSet>> asked() {
        std::vector<std::pair<int, ChannelSet>> all;
        while (const auto question = router->take_question(now)) all.emplace_back(question->address, question->channels);
        return all;
    }
    /// The claims that are made now meet silence.
    void silence() {
        for (asked(); router->next_question(); asked()) now = *router->next_question();
    }
    Router* operator->() const { return router.get(); }

    std::unique_ptr<Router> router;
    TimePoint now{};
};

ChannelSet channels(std::initializer_list<unsigned> numbers) {
    ChannelSet set;
    for (const unsigned n : numbers) set.insert(static_cast<ChannelId>(n));
    return set;
}
LinkSet links(std::initializer_list<unsigned> numbers) {
    LinkSet set;
    for (const unsigned n : numbers) set.insert(static_cast<LinkId>(n));
    return set;
}
constexpr LinkId link(unsigned n) { return static_cast<LinkId>(n); }
constexpr ChannelId channel(unsigned n) { return static_cast<ChannelId>(n); }

void expect(const Route& route, ChannelSet to, Via via, LinkSet absent = {}) {
    EXPECT_EQ(route.channels, to);
    EXPECT_EQ(text(route.via), text(via));
    EXPECT_EQ(route.absent, absent);
}

TEST(Router, forgets_where_an_address_was_heard) {
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

TEST(Router, forgets_the_conflict_about_an_address_as_well) {
    Net net;
    net->note_conflict(0xDC, links({0, 1}), std::nullopt, net.now);
    net->note_conflict(0xDD, links({0, 1}), std::nullopt, net.now);
    net->forget(0xDC);
    const auto left = net->conflicts(net.now);
    ASSERT_EQ(left.size(), 1u);
    EXPECT_EQ(left[0].address, 0xDD);
}

TEST(Router, what_was_heard_by_the_program_before_leads_where_it_did) {
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

TEST(Router, who_was_heard_before_is_as_old_as_that) {
    Net net;
    net.now += 1min;
    net->restore(0xDC, channel(1), net.now - 10s);
    EXPECT_EQ(net->heard_at(0xDC, channel(1)), net.now - 10s);
}

TEST(Router, a_channel_that_is_closed_leaves_nothing_to_the_next_of_its_number) {
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

TEST(Router, a_host_by_the_only_other_channel_needs_no_guard_once_the_third_is_closed) {
    Net net{{}, {{}, {}, {}}};
    net.route(1, 0xFE, 0xFF);
    EXPECT_EQ(net.route(0, 0xDC, 0xFE).guarded, channels({1}));
    net->close(channel(2));
    EXPECT_EQ(net.route(0, 0xDC, 0xFE).guarded, ChannelSet{});
}

TEST(Router, of_two_new_conflicts_the_second_is_told_too) {
    Net net;
    net->note_conflict(0xDC, links({0, 1}), std::nullopt, net.now);
    net->note_conflict(0xDD, links({0, 1}), std::nullopt, net.now);
    Conflict conflict;
    ASSERT_TRUE(net->take_new_conflict(conflict));
    EXPECT_TRUE(net.route(2, 0x10, 0xFF).new_conflict);
    ASSERT_TRUE(net->take_new_conflict(conflict));
    EXPECT_EQ(conflict.address, 0xDD);
    EXPECT_FALSE(net.route(2, 0x10, 0xFF).new_conflict);
}

TEST(Router, nobody_and_everybody_are_not_restored) {
    Net net;
    net.router->restore(0x00, ChannelId{0}, net.now);
    net.router->restore(0xFF, ChannelId{0}, net.now);
    EXPECT_EQ(net.router->heard_at(0x00, ChannelId{0}), std::nullopt);
    EXPECT_EQ(net.router->heard_at(0xFF, ChannelId{0}), std::nullopt);
}

}    // namespace

TEST(Router, broadcast_goes_everywhere_but_back) {
    Net net{{}, {{}, {}, {.broadcast = false}, {}}};
    expect(net.route(0, 0xDC, 0xFF), channels({1, 3}), Via::broadcast);
    expect(net.route(2, 0xDD, 0xFF), channels({0, 1, 3}), Via::broadcast);
}

TEST(Router, port_id_is_the_link_that_bears_it) {
    Net net{{}, {{}, {.port_id = 5}, {}, {}}};
    expect(net.route(0, 0xFE, 5), channels({1}), Via::port);
    net.route(2, 5, 0xFE);
    expect(net.route(0, 0xFE, 5), channels({1}), Via::port);    // whatever is behind it
    expect(net.route(1, 0xFE, 5), {}, Via::port);               // never back
}

TEST(Router, port_id_that_no_link_bears_is_an_address_like_any) {
    Net net;
    net.route(2, 7, 0xFE);
    expect(net.route(0, 0xFE, 7), channels({2}), Via::learned);
}

TEST(Router, pinned_address_goes_to_its_links_wherever_it_was_heard) {
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

TEST(Router, link_with_several_channels_gives_to_all_but_the_one_it_came_by) {
    Net net;
    net->open(channel(10), link(1));
    net->open(channel(11), link(1));
    net->pin(50, 50, link(1));
    expect(net.route(0, 0xFE, 50), channels({1, 10, 11}), Via::pinned);
    expect(net.route(10, 0xFE, 50), channels({1, 11}), Via::pinned);
}

TEST(Router, learned_address_goes_where_it_was_heard) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    expect(net.route(1, 0xFE, 0xDC), {}, Via::learned);    // a neighbour on the same line: it has heard it already
}

TEST(Router, learned_address_is_forgotten_after_its_time) {
    Net net{settings([](auto& s) { s.forget_after = 10s; })};
    net.route(1, 0xDC, 0xFF);
    net.now += 10s - 1ns;
    EXPECT_EQ(net.route(0, 0xFE, 0xDC).via, Via::learned);
    EXPECT_EQ(net->learned(0xDC, net.now).links, links({1}));
    net.now += 1ns;
    EXPECT_EQ(net->learned(0xDC, net.now).links, LinkSet{});
    expect(net.route(0, 0xFE, 0xDC), channels({1, 2, 3}), Via::unknown);
}

TEST(Router, device_that_moved_is_followed_after_three_seconds_of_silence) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    net.now += 60s;    // forgotten, and asked all the same
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

TEST(Router, any_frame_by_the_old_way_refuses_a_claim) {
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
        ASSERT_TRUE(net->take_claimant(claimant));
        EXPECT_EQ(claimant.address, 0xDC);
        EXPECT_EQ(claimant.channel, channel(2));
        EXPECT_FALSE(net->take_claimant(claimant));
        net.now += 20s;
        expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    }
}

TEST(Router, one_test_of_an_address_in_ten_seconds) {
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

// 40 commands in 40 s, the thief speaks ten times a second, the device every 4 s and when it is asked.
TEST(Router, device_that_speaks_now_and_then_keeps_its_address) {
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

// It answers nothing and speaks every 4 s, so that its silence is long enough.
TEST(Router, who_speaks_again_at_its_first_home_is_back_at_once) {
    Net net;
    int reached = 0, stolen = 0;
    for (unsigned tenth = 0; tenth < 400; ++tenth, net.now += 100ms) {
        if (tenth % 40 == 0) net.route(1, 0xDC, 0xFF);
        net.route(2 + tenth / 100 % 2, 0xDC, 0xFF);    // from one port and from another
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

TEST(Router, way_back_home_is_no_conflict) {
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

// A constant broadcast that somebody else repeats ends in the loop guard.
TEST(Router, what_goes_no_further_brings_it_home_as_well) {
    Net net;
    net.route(1, 0xDC, 0xFF);
    EXPECT_EQ(net->speaks(0xDC, channel(1)), Speaks::at_home);
    net.route(2, 0xDC, 0xFF);
    EXPECT_EQ(net->speaks(0xDC, channel(2)), Speaks::elsewhere);
    net.silence();
    net.route(2, 0xDC, 0xFF);
    EXPECT_EQ(net->speaks(0xDC, channel(2)), Speaks::elsewhere) << "it may still be one who takes its name";
    EXPECT_EQ(net->speaks(0xDC, channel(1)), Speaks::somewhere);
    EXPECT_FALSE(net->heard_again(channel(3), 0xDC, net.now));
    EXPECT_TRUE(net->heard_again(channel(1), 0xDC, net.now));
    EXPECT_EQ(net->speaks(0xDC, channel(1)), Speaks::at_home);
    Router::Claimant claimant;
    ASSERT_TRUE(net->take_claimant(claimant));
    EXPECT_EQ(claimant.channel, channel(2));
}

// Two cables of one device and no `group`: the first breaks when a test was just refused.
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

TEST(Router, what_has_no_wire_is_silent_at_once) {
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

TEST(Router, peers_of_one_link_are_different_places) {
    Net net;
    net->open(channel(10), link(1));
    net.route(1, 0xDC, 0xFF);
    net.route(10, 0xDC, 0xFF);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net.silence();
    expect(net.route(0, 0xFE, 0xDC), channels({10}), Via::learned);
}

TEST(Router, pinned_address_refuses_every_claim_and_asks_nobody) {
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

TEST(Router, a_host_whose_wires_are_gone_is_sought_where_nobody_was_heard) {
    Net net;
    for (const unsigned n : {1u, 2u}) net.route(n, 0xFE, 0xFF);
    net->went_down(channel(1));
    expect(net.route(0, 0xDC, 0xFE), channels({1, 2}), Via::learned);
    net->went_down(channel(2));
    expect(net.route(0, 0xDC, 0xFE), channels({1, 2, 3}), Via::unknown);
    expect(net->find(link(0), 0xFE, net.now), channels({0, 1, 2, 3}), Via::unknown);
    EXPECT_TRUE(net.route(0, 0xDC, 0xFE).host_is_down);
    EXPECT_FALSE(net.route(0, 0xDC, 0xD2).host_is_down) << "it was never heard";
    net.route(1, 30, 0xFF);
    expect(net.route(0, 0xFE, 30), channels({1}), Via::learned);    // a device is where it was
    net->came_up(channel(1));
    expect(net.route(3, 0xDC, 0xFE), channels({0, 1, 2}), Via::learned);    // 0 spoke as the host, too
}

TEST(Router, a_host_whose_wires_are_gone_is_sought_as_far_as_unheard_addresses_are) {
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
    net->open(channel(1), link(1));    // its number used again knows nothing of the one before
    expect(net.route(0, 0xDC, 0xFE), channels({2}), Via::learned);
    EXPECT_TRUE(net->conflicts(net.now).empty());
}

TEST(Router, unknown_is_flooded_dropped_or_sent_to_one_link) {
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

TEST(Router, no_receiver_and_no_sender_teach_nothing) {
    Net net;
    net.route(1, 0x00, 0xFE);
    net.route(1, 0xFF, 0xFE);
    EXPECT_EQ(net->learned(0x00, net.now).links, LinkSet{});
    EXPECT_EQ(net->learned(0xFF, net.now).links, LinkSet{});
    net->pin(0, 0, link(2));
    expect(net.route(0, 0xFE, 0x00), {}, Via::nobody);
    EXPECT_EQ(net->learned(0xFE, net.now).links, links({0}));    // its source is learned all the same
}

TEST(Router, own_id_ends_here) {
    Net net{settings([](auto& s) { s.id = 199; })};
    net->pin(199, 199, link(2));
    expect(net.route(0, 0xFE, 199), {}, Via::own);
    EXPECT_EQ(net->own_frames(), 1u);
    EXPECT_EQ(net.route(0, 0xFE, 0x00).via, Via::nobody);
    EXPECT_EQ(net->own_frames(), 1u);
}

TEST(Router, source_on_two_links_is_a_conflict_while_both_speak) {
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
    ASSERT_TRUE(net->take_new_conflict(conflict));
    EXPECT_EQ(conflict.address, 0xDE);
    const auto end = net.now + 60s;
    while (net.now < end) both(1, 2);
    net.route(1, 0xDE, 0xFF);
    EXPECT_FALSE(net->take_new_conflict(conflict)) << "told once";
    net.now += 30s;
    EXPECT_TRUE(net->conflicts(net.now).empty());
    both(1, 3);
    net.route(1, 0xDE, 0xFF);
    ASSERT_TRUE(net->take_new_conflict(conflict)) << "a new one is told again";
    EXPECT_EQ(conflict.links, links({1, 3}));
}

// Where what was heard is forgotten sooner than the next test may begin.
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

TEST(Router, every_new_conflict_is_told) {
    Net net;
    for (const std::uint8_t source : std::initializer_list<std::uint8_t>{0xDE, 0xDD, 0x20})
        for (const unsigned from : {1u, 2u, 1u}) net.route(from, source, 0xFF);
    Conflict conflict;
    std::vector<int> told;
    while (net->take_new_conflict(conflict)) told.push_back(conflict.address);
    EXPECT_EQ(told, (std::vector<int>{0x20, 0xDD, 0xDE}));
}

// Links 1 and 2 lead to the same place.
struct GroupedRouter : testing::Test {
    Net net{{}, {{}, {.group = 1}, {.group = 1}, {}}};
};

TEST_F(GroupedRouter, frames_leave_by_the_member_heard_most_recently) {
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

TEST_F(GroupedRouter, frames_never_go_back_where_they_came_from) {
    net.route(1, 0xDC, 0xFE);
    net.route(2, 0xDD, 0xFE);
    expect(net.route(1, 0xDC, 0xFF), channels({0, 3}), Via::broadcast);
    expect(net.route(1, 0xDC, 0xDD), {}, Via::learned);
    net->open(channel(10), link(1));
    expect(net.route(1, 0xDC, 0xFF), channels({0, 3, 10}), Via::broadcast);    // but to another peer of the link
}

TEST_F(GroupedRouter, all_members_get_it_until_one_is_heard) {
    expect(net.route(0, 0xFE, 0xFF), channels({1, 2, 3}), Via::broadcast);
    net.route(2, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 0xFF), channels({2, 3}), Via::broadcast);
    net.now += Router::group_silence;
    expect(net.route(0, 0xFE, 0xFF), channels({1, 2, 3}), Via::broadcast);
    expect(net.route(0, 0xFE, 0xDC), channels({1, 2}), Via::learned);
}

TEST_F(GroupedRouter, a_member_that_is_down_is_passed_over) {
    net.route(2, 0xDC, 0xFE);
    net->went_down(channel(2));
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net->went_down(channel(1));
    expect(net.route(0, 0xFE, 0xDC), channels({2}), Via::learned);    // counted link_down, once
    net->came_up(channel(1));
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
    net->came_up(channel(2));
    net->report_unreachable(link(2));
    expect(net.route(0, 0xFE, 0xDC), channels({1, 2}), Via::learned);
}

TEST_F(GroupedRouter, a_member_without_a_channel_is_not_missed) {
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

TEST(Router, a_port_id_of_a_group_is_that_port) {
    Net net{{}, {{}, {.port_id = 5, .group = 1}, {.port_id = 6, .group = 1}}};
    net.route(2, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 5), channels({1}), Via::port);
}

TEST(Router, members_that_take_no_broadcast_get_none) {
    Net net{{}, {{}, {.broadcast = false, .group = 1}, {.group = 1}}};
    net.route(1, 0xDC, 0xFE);
    expect(net.route(0, 0xFE, 0xFF), channels({2}), Via::broadcast);
    expect(net.route(0, 0xFE, 0xDC), channels({1}), Via::learned);
}

TEST(Router, what_was_spread_is_guarded) {
    Net net{{}, {{}, {.group = 1}, {.group = 1}, {}}};
    net.route(1, 0xDC, 0xFE);
    EXPECT_EQ(net.route(0, 0xFE, 0xFF).guarded, channels({1, 2, 3}));
    EXPECT_EQ(net.route(0, 0xFE, 60).guarded, channels({1, 2, 3}));
    EXPECT_EQ(net.route(0, 0xFE, 0xDC).guarded, ChannelSet{});
    net.route(3, 0xFE, 0xFF);
    EXPECT_EQ(net.route(1, 0xDC, 0xFE).guarded, channels({0, 3})) << "two hosts";
}

// The channel of the same number goes first.
TEST(Router, a_link_that_is_removed_leaves_nothing_to_the_next_of_its_number) {
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

TEST(Router, the_lowest_free_number_is_the_next) {
    Net net;
    for (const unsigned n : {1u, 2u}) {
        net->close(channel(n));
        net->remove_link(link(n));
    }
    EXPECT_EQ(net->add_link({}), link(1));
    EXPECT_EQ(net->add_link({}), link(2));
    EXPECT_EQ(net->add_link({}), link(4));
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
    ASSERT_TRUE(net->take_new_conflict(conflict));
    EXPECT_EQ(conflict.address, 0xDD);
    EXPECT_FALSE(net->take_new_conflict(conflict)) << "of the others nothing is told";
}
