#include <http/places.hpp>
#include <http/request.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace anogate::http::places_tests {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t places = 32;
constexpr std::uint32_t root = 0, alice = 1000, bob = 1001;

Visitor of(std::uint32_t user, Asking asking, int second) {
    return {{user}, asking, ano::TimePoint{} + std::chrono::seconds{second}};
}
Visitor by_network(std::uint64_t client, Asking asking, int second = 1) {
    return {{unknown_user, client}, asking, ano::TimePoint{} + std::chrono::seconds{second}};
}
std::optional<std::size_t> gives_way(const std::vector<Visitor>& visitors, std::uint32_t user, bool first) {
    return http::gives_way(visitors, {user}, first);
}
std::optional<std::size_t> gives_way_to_client(const std::vector<Visitor>& visitors, std::uint64_t client) {
    return http::gives_way(visitors, {unknown_user, client}, false);
}
Visitor idle(std::uint32_t user, int second) { return of(user, Asking::nothing, second); }
Visitor half(std::uint32_t user, int second) { return of(user, Asking::half, second); }
Visitor unheard(std::uint32_t user, int second) { return of(user, Asking::unheard, second); }
Visitor busy(std::uint32_t user, int second) { return of(user, Asking::whole, second); }

std::vector<Visitor> fill(std::vector<Visitor> visitors, Visitor rest) {
    visitors.resize(places, rest);
    return visitors;
}

TEST(Places, of_one_user_the_one_that_is_idle_the_longest_gives_way) {
    EXPECT_EQ(gives_way(fill({idle(alice, 9), busy(alice, 1), idle(alice, 3)}, idle(alice, 5)), alice, false), 2u);
}

TEST(Places, of_ones_own_no_request_is_cut_short) {
    EXPECT_EQ(gives_way(fill({}, busy(alice, 5)), alice, true), std::nullopt);
    EXPECT_EQ(gives_way(fill({idle(bob, 1)}, busy(alice, 5)), alice, true), std::nullopt)
        << "nor is another within his share driven out";
}

TEST(Places, who_asked_half_a_request_gives_way_before_who_was_not_heard_yet) {
    EXPECT_EQ(gives_way(fill({unheard(alice, 1), busy(alice, 1), half(alice, 3), half(alice, 2)}, half(alice, 5)), alice, false),
              3u);
    EXPECT_EQ(gives_way(fill({unheard(alice, 2), half(alice, 9)}, unheard(alice, 1)), alice, false), 1u);
    EXPECT_EQ(gives_way(fill({unheard(alice, 2), unheard(alice, 1)}, busy(alice, 1)), alice, false), 1u) << "and then he does";
}

TEST(Places, of_two_sorts_the_crowd_gives_way) {
    EXPECT_EQ(gives_way(fill({idle(alice, 1), half(alice, 2), busy(alice, 1)}, half(alice, 3)), alice, false), 1u)
        << "who floods by halves";
    EXPECT_EQ(gives_way(fill({half(alice, 1), idle(alice, 2), busy(alice, 1)}, idle(alice, 3)), alice, false), 1u)
        << "who floods and is silent";
    EXPECT_EQ(gives_way(fill({half(alice, 1), idle(alice, 2)}, busy(alice, 3)), alice, false), 1u);
    EXPECT_EQ(gives_way(fill({half(bob, 1), half(bob, 2), idle(alice, 3)}, busy(alice, 4)), alice, false), 2u)
        << "others' are not counted";
}

TEST(Places, who_has_less_than_his_share_gets_one_of_who_has_most) {
    EXPECT_EQ(gives_way(fill({idle(root, 1), busy(alice, 1), idle(alice, 7), idle(alice, 8)}, busy(alice, 3)), bob, false), 2u);
    EXPECT_EQ(gives_way(fill({idle(root, 1), busy(alice, 4), busy(alice, 2)}, busy(alice, 3)), bob, false), 2u)
        << "busy as well, beyond it";
}

TEST(Places, two_users_end_with_half_of_them_each) {
    std::vector<Visitor> visitors = fill({}, busy(alice, 1));
    for (int i = 0; i < 100; ++i)
        if (const auto place = gives_way(visitors, bob, false)) visitors[*place] = busy(bob, i);
    EXPECT_EQ(std::count_if(visitors.begin(), visitors.end(), [](const Visitor& v) { return v.party.user == bob; }), 16);
}

TEST(Places, more_users_than_places_share_what_is_idle_and_root_is_never_locked_out) {
    std::vector<Visitor> visitors;
    for (std::uint32_t user = 1; user <= places; ++user) visitors.push_back(busy(user, 50 - static_cast<int>(user)));
    EXPECT_EQ(gives_way(visitors, alice, false), std::nullopt);
    EXPECT_EQ(gives_way(visitors, root, true), places - 1);
    visitors[4].asking = Asking::half;
    EXPECT_EQ(gives_way(visitors, alice, false), 4u);
    EXPECT_EQ(gives_way(visitors, root, true), 4u);
}

Visitor with(Visitor visitor, std::optional<Access> may) {
    visitor.may = may;
    return visitor;
}

TEST(Places, clients_of_the_network_share_what_it_has) {
    const std::vector<Visitor> one_takes_all = fill({by_network(1, Asking::whole, 4)}, by_network(1, Asking::whole, 5));
    EXPECT_EQ(gives_way_to_client(one_takes_all, 1), std::nullopt);
    EXPECT_EQ(gives_way_to_client(one_takes_all, 2), 0u) << "whole requests too, beyond its share";
    std::vector<Visitor> half_each = fill({}, by_network(2, Asking::whole));
    std::fill_n(half_each.begin(), places / 2, by_network(1, Asking::whole));
    EXPECT_EQ(gives_way_to_client(half_each, 2), std::nullopt);
    EXPECT_EQ(gives_way_to_client(half_each, 1), std::nullopt);
    EXPECT_NE(gives_way_to_client(half_each, 3), std::nullopt);
    std::vector<Visitor> three = fill({}, by_network(1, Asking::whole));
    std::fill_n(three.begin(), 11, by_network(2, Asking::whole));
    std::fill_n(three.begin() + 11, 7, by_network(3, Asking::whole));
    EXPECT_EQ(gives_way_to_client(three, 2), std::nullopt) << "has his share of ten, though another has more";
    EXPECT_EQ(gives_way_to_client(three, 3), 18u);
}

TEST(Places, of_the_network_who_asks_nothing_gives_way_to_each_and_first_those_of_a_crowd) {
    std::vector<Visitor> visitors = fill({by_network(2, Asking::nothing, 1)}, by_network(1, Asking::whole, 2));
    EXPECT_EQ(gives_way_to_client(visitors, 1), 0u) << "also to whom has his share";
    visitors[5] = by_network(3, Asking::nothing, 4);
    visitors[6] = by_network(3, Asking::nothing, 3);
    EXPECT_EQ(gives_way_to_client(visitors, 2), 6u);
    visitors[6].may = Access::control;
    visitors[7] = by_network(3, Asking::unheard, 9);
    EXPECT_EQ(gives_way_to_client(visitors, 2), 5u);
    visitors[5] = visitors[0] = visitors[7] = visitors[8];
    EXPECT_EQ(gives_way_to_client(visitors, 2), 6u) << "who may control is the last of them";
}

TEST(Places, more_clients_than_the_network_has_places_share_what_is_idle) {
    std::vector<Visitor> visitors;
    for (std::uint64_t client = 0; client < places; ++client) visitors.push_back(by_network(client, Asking::whole));
    EXPECT_EQ(gives_way_to_client(visitors, 99), std::nullopt);
    visitors[7].asking = Asking::half;
    EXPECT_EQ(gives_way_to_client(visitors, 99), 7u);
}

TEST(Places, who_controls_by_the_network_gives_way_to_no_client_and_takes_a_place_of_who_looks) {
    std::vector<Visitor> visitors = fill({}, with(by_network(1, Asking::whole), Access::control));
    EXPECT_EQ(gives_way_to_client(visitors, 2), std::nullopt);
    EXPECT_EQ(gives_way_to_client(visitors, 1), std::nullopt);
    EXPECT_EQ(gives_way(visitors, alice, false), 0u) << "a user of this machine has his share all the same";
    visitors[3] = visitors[4] = with(by_network(3, Asking::whole, 2), Access::view);
    visitors[5] = with(by_network(4, Asking::whole, 1), Access::view);
    EXPECT_EQ(gives_way_to_client(visitors, 2), std::nullopt) << "who looks has not more than his share";
    EXPECT_EQ(gives_way_to_client(visitors, 1), 3u) << "and gives way to who has shown that he may control: who has most first";
    EXPECT_EQ(gives_way(visitors, alice, false), 3u);
}

TEST(Places, the_network_is_one_beside_the_users_however_many_its_clients) {
    std::vector<Visitor> visitors;
    for (std::uint64_t client = 0; client < 16; ++client) visitors.push_back(by_network(client, Asking::whole));
    for (int i = 0; i < 16; ++i) visitors.push_back(busy(alice, 1));
    EXPECT_EQ(gives_way_to_client(visitors, 99), std::nullopt) << "alice keeps her half";
    EXPECT_EQ(gives_way(visitors, alice, false), std::nullopt);
    visitors[16] = by_network(5, Asking::whole, 2);
    EXPECT_EQ(gives_way(visitors, alice, false), 5u) << "of the client that has most";
    visitors[0].asking = Asking::nothing;
    visitors[20] = idle(alice, 0);
    EXPECT_EQ(gives_way_to_client(visitors, 0), 0u) << "a number of a client is none of a user";
    visitors[0].asking = Asking::whole;
    visitors[20] = busy(alice, 1);
    visitors[3].asking = Asking::unheard;
    EXPECT_EQ(gives_way(visitors, alice, false), 3u);
}

TEST(Places, a_client_is_an_address_and_of_ipv6_its_first_half) {
    const auto client_at = [](const std::string& peer) {
        Door door;
        door.is_network = true;
        door.peer = peer;
        const Party party = party_of(unknown_user, door);
        EXPECT_EQ(party.user, unknown_user);
        return party.client;
    };
    EXPECT_NE(client_at("192.168.1.5"), client_at("192.168.1.6"));
    EXPECT_EQ(client_at("fd00::1"), client_at("fd00::2:3:4:5"));
    EXPECT_EQ(client_at("fe80::1%eth0"), client_at("fe80::2%eth0"));
    EXPECT_NE(client_at("fd00::1"), client_at("fd00:0:0:1::1"));
    EXPECT_EQ(party_of(alice, Door{}).user, alice);
    EXPECT_EQ(party_of(alice, Door{}).client, party_of(bob, Door{}).client);
}

TEST(Places, one_in_eight_is_kept_for_who_controls) {
    std::vector<Visitor> visitors(14, with(by_network(1, Asking::whole), Access::view));
    visitors.resize(28, with(by_network(1, Asking::whole), Access::open));
    EXPECT_TRUE(has_place(visitors, places, Access::view)) << "the last of them";
    visitors.push_back(visitors.front());
    EXPECT_FALSE(has_place(visitors, places, Access::view));
    EXPECT_FALSE(has_place(visitors, places, Access::open));
    EXPECT_TRUE(has_place(visitors, places, Access::control));
    for (const Asking asking : {Asking::nothing, Asking::half, Asking::unheard}) {
        visitors[0].asking = asking;
        EXPECT_TRUE(has_place(visitors, places, Access::view)) << "this one gives way";
    }
    visitors[0] = with(by_network(1, Asking::whole), Access::control);
    EXPECT_TRUE(has_place(visitors, places, Access::view));
    EXPECT_TRUE(has_place({visitors.data() + 1, 7}, 7, Access::open)) << "of so few none";
    EXPECT_TRUE(has_place({visitors.data() + 1, 14}, 15, Access::view)) << "one in seven would be two";
}

TEST(Places, one_is_left_to_whom_was_not_heard_yet) {
    std::vector<Visitor> visitors(11, with(by_network(1, Asking::whole), Access::control));
    visitors.resize(places - 1, with(by_network(2, Asking::whole), Access::view));
    visitors.push_back(by_network(3, Asking::unheard));
    EXPECT_TRUE(has_place(visitors, places, Access::view));
    EXPECT_EQ(leaves_room(visitors, places), std::nullopt);
    visitors.back().asking = Asking::whole;
    EXPECT_FALSE(has_place(visitors, places, Access::view)) << "it would be the last";
    visitors.back().may = Access::control;
    EXPECT_TRUE(has_place(visitors, places, Access::control));
    EXPECT_EQ(leaves_room(visitors, places), 11u) << "who looks makes room";
    EXPECT_EQ(leaves_room({visitors.data() + 11, 7}, 7), std::nullopt) << "of so few none";
    for (Visitor& visitor : visitors) visitor.may = Access::control;
    EXPECT_EQ(leaves_room(visitors, places), std::nullopt) << "there is none who looks";
}

}    // namespace
}    // namespace anogate::http::places_tests
