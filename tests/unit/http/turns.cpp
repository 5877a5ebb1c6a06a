#include <http/turns.hpp>

#include <gtest/gtest.h>

namespace anogate::http::turns_tests {
namespace {

TEST(Turns, whoever_waits_longest_is_next) {
    Turns<int> turns;
    EXPECT_TRUE(turns.wait(1)) << "to be arranged";
    EXPECT_FALSE(turns.wait(2)) << "it is";
    EXPECT_FALSE(turns.wait(3));
    EXPECT_EQ(turns.next(), 1);
    EXPECT_TRUE(turns.is_arranged());
    EXPECT_FALSE(turns.wait(1)) << "behind those who wait";
    EXPECT_EQ(turns.next(), 2);
    EXPECT_EQ(turns.next(), 3);
    EXPECT_EQ(turns.next(), 1);
    EXPECT_FALSE(turns.is_arranged());
    EXPECT_TRUE(turns.wait(4));
}

TEST(Turns, who_left_gets_none) {
    Turns<int> turns;
    turns.wait(1);
    turns.wait(2);
    turns.leave(1);
    turns.leave(7);
    EXPECT_EQ(turns.next(), 2);
    turns.wait(3);
    turns.leave(3);
    EXPECT_EQ(turns.next(), std::nullopt) << "what was arranged for him";
    EXPECT_TRUE(turns.wait(4));
    turns.clear();
    EXPECT_EQ(turns.next(), std::nullopt);
    EXPECT_FALSE(turns.is_arranged());
}

}    // namespace
}    // namespace anogate::http::turns_tests
