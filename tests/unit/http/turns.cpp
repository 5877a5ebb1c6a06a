#include <http/turns.hpp>

#include <gtest/gtest.h>

namespace anogate::http::turns_tests {
namespace {

TEST(Turns, the_entry_that_waits_longest_is_next) {
    Turns<int, char> turns;
    EXPECT_TRUE(turns.wait(1, 'a', false)) << "to be arranged";
    EXPECT_FALSE(turns.wait(2, 'a', false)) << "it is";
    EXPECT_FALSE(turns.wait(3, 'a', false));
    EXPECT_EQ(turns.next(), 1);
    EXPECT_TRUE(turns.is_arranged());
    EXPECT_FALSE(turns.wait(1, 'a', false)) << "behind those who wait";
    EXPECT_EQ(turns.next(), 2);
    EXPECT_EQ(turns.next(), 3);
    EXPECT_EQ(turns.next(), 1);
    EXPECT_FALSE(turns.is_arranged());
    EXPECT_TRUE(turns.wait(4, 'a', false));
}

TEST(Turns, a_removed_entry_has_no_turn) {
    Turns<int, char> turns;
    turns.wait(1, 'a', false);
    turns.wait(2, 'a', false);
    turns.leave(1);
    turns.leave(7);
    EXPECT_EQ(turns.next(), 2);
    turns.wait(3, 'a', false);
    turns.leave(3);
    EXPECT_EQ(turns.next(), std::nullopt) << "what was arranged for him";
    EXPECT_TRUE(turns.wait(4, 'a', false));
    turns.clear();
    EXPECT_EQ(turns.next(), std::nullopt);
    EXPECT_FALSE(turns.is_arranged());
}

TEST(Turns, entries_with_priority_precede_all_others) {
    Turns<int, char> turns;
    for (int i = 0; i < 20; ++i) turns.wait(i, 'a', false);
    turns.wait(100, 'b', true);
    EXPECT_EQ(turns.next(), 100);
    EXPECT_EQ(turns.next(), 0);
}

TEST(Turns, every_client_has_a_turn_between_two_turns_of_another) {
    Turns<int, char> turns;
    for (int i = 0; i < 20; ++i) turns.wait(i, 'a', false);
    turns.wait(100, 'b', false);
    EXPECT_EQ(turns.next(), 0);
    EXPECT_EQ(turns.next(), 100) << "the next of the first client would be its second";
    turns.wait(101, 'b', false);
    EXPECT_EQ(turns.next(), 1) << "of two that are in the same round, who waits longer";
    EXPECT_EQ(turns.next(), 101);
}

}    // namespace
}    // namespace anogate::http::turns_tests
