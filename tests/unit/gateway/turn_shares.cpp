// Whose turn it is among channels that have received more than can be processed.
#include <gateway/turn_shares.hpp>

#include <gtest/gtest.h>

#include <array>

namespace anogate::turn_shares_tests {
namespace {

using namespace std::chrono_literals;

constexpr ChannelId a{0}, b{1}, c{2};

TEST(TurnShares, give_each_channel_the_same_time_however_long_its_turns_are) {
    TurnShares shares;
    std::array<ano::Duration, 2> used{};
    const ChannelSet both = ChannelSet{a} | b;
    for (const ChannelId id : both) shares.begins(id);
    for (int i = 0; i < 1000; ++i) {
        const ChannelId id = shares.next(both);
        const ano::Duration time = id == a ? 10us : 300us;
        shares.charge(id, time);
        used[index(id)] += time;
    }
    EXPECT_LE(used[0] - used[1], 310us);
    EXPECT_LE(used[1] - used[0], 310us);
}

TEST(TurnShares, serve_a_channel_with_little_data_before_channels_that_always_have_data) {
    TurnShares shares;
    ChannelSet waiting = ChannelSet{b} | c;
    for (const ChannelId id : waiting) shares.begins(id);
    for (int round = 0; round < 100; ++round) {
        for (int i = 0; i < 7; ++i) shares.charge(shares.next(waiting), 100us);
        shares.begins(a);
        waiting.insert(a);
        int before = 0;
        for (; shares.next(waiting) != a; ++before) shares.charge(shares.next(waiting), 100us);
        EXPECT_LE(before, 1) << round;
        shares.charge(a, 10us);
        waiting.erase(a);
    }
}

TEST(TurnShares, time_that_was_not_used_is_not_saved) {
    TurnShares shares;
    shares.begins(b);
    for (int i = 0; i < 1000; ++i) shares.charge(shares.next(b), 100us);
    shares.begins(a);
    int in_a_row = 0;
    for (; shares.next(ChannelSet{a} | b) == a; ++in_a_row) shares.charge(a, 100us);
    EXPECT_LE(in_a_row, 2);
}

}    // namespace
}    // namespace anogate::turn_shares_tests
