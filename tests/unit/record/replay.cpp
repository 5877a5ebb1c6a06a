#include <gtest/gtest.h>
#include <record/replay.hpp>

#include <chrono>
#include <initializer_list>

#include <support/bytes.hpp>

namespace {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

const Bytes euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});

ano::Duration due(ReplayClock& clock, std::chrono::nanoseconds time, std::chrono::nanoseconds boottime) {
    return clock.due({.time_ns = static_cast<std::uint64_t>(time.count()),
                      .boottime_ns = static_cast<std::uint64_t>(boottime.count()),
                      .frame = ano::FrameView{euler}});
}

bool may(const Bytes& frame) { return may_command(ano::FrameView{frame}); }

TEST(Replay, says_nothing_again_that_may_move_a_vehicle) {
    EXPECT_FALSE(may(euler));
    EXPECT_FALSE(may(support::frame(0xDC, 0xFF, 0xA0, {1, 'a'})));
    EXPECT_TRUE(may(support::frame(0xFE, 0xDC, 0x03, {0x7B, 0, 0, 0, 0, 0, 1})));    // of a host
    EXPECT_TRUE(may(support::frame(0xD2, 0xDC, 0x03, {0x7B, 0, 0, 0, 0, 0, 1})));
    for (const std::uint8_t id : std::initializer_list<std::uint8_t>{0x40, 0x41, 0x61, 0xC0, 0xE1, 0xF0})
        EXPECT_TRUE(may(support::frame(0x30, 0xDC, id, {0, 0, 0}))) << +id;
    EXPECT_TRUE(may(support::frame(0x30, 0xDC, 0xE0, {0x10, 0xAB, 0})));
    EXPECT_FALSE(may(support::frame(0x30, 0xDC, 0xE0, {0, 0, 0})));    // asks
    const Bytes command = support::frame(0x30, 0xDC, 0x40, {0, 0, 0});
    Bytes content{192, 168, 0, 1, 0x0A, 0x1A, 192, 168, 0, 2, 0x0A, 0x1A};
    EXPECT_TRUE(may(support::frame(0x30, 0xDC, 0xB1, {1, 2, 3})));    // can't be read
    content.insert(content.end(), command.begin(), command.end());
    EXPECT_TRUE(may(support::frame(0x30, 0xDC, 0xB1, content)));
}

TEST(Replay, keeps_the_distances_of_the_frames) {
    ReplayClock clock{1}, twice{2};
    EXPECT_EQ(due(clock, 1000s, 10s), 0ns);
    EXPECT_EQ(due(clock, 1001s, 11s), 1s);
    EXPECT_EQ(due(clock, 1001500ms, 11500ms), 1500ms);
    EXPECT_EQ(due(twice, 1000s, 10s), 0ns);
    EXPECT_EQ(due(twice, 1001s, 11s), 500ms);
}

TEST(Replay, a_clock_that_was_set_changes_nothing) {
    ReplayClock clock{1};
    due(clock, 1000s, 10s);
    EXPECT_EQ(due(clock, 1000s - 1h, 11s), 1s);
    EXPECT_EQ(due(clock, 1002s, 12s), 2s);
    EXPECT_EQ(due(clock, 1003s, 5s), 2s);    // another start of the computer: files that were joined
    EXPECT_EQ(due(clock, 1004s, 6s), 3s);
    ReplayClock other{1};
    due(other, 1000s, 0s);
    EXPECT_EQ(due(other, 1001s, 0s), 1s);
    EXPECT_EQ(due(other, 900s, 0s), 1s);
    EXPECT_EQ(due(other, 901s, 0s), 2s);
}

TEST(Replay, hostile_times_stay_times) {
    ReplayClock clock{0.001};
    due(clock, 0s, 0s);
    const auto last = clock.due({.time_ns = ~std::uint64_t{0}, .frame = ano::FrameView{euler}});
    EXPECT_LE(last, 24h * 365);
    EXPECT_GT(last, 0s);
}

}    // namespace
