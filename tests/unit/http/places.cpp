#include <http/places.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace anogate::http {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t places = 32;
constexpr std::uint32_t root = 0, alice = 1000, bob = 1001;

Visitor of(std::uint32_t user, Asking asking, int second) {
    return {user, asking, ano::TimePoint{} + std::chrono::seconds{second}};
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
    EXPECT_EQ(std::count_if(visitors.begin(), visitors.end(), [](const Visitor& v) { return v.user == bob; }), 16);
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

}    // namespace
}    // namespace anogate::http
