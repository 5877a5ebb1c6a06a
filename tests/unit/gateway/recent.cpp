#include <gateway/recent.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

constexpr TimePoint start{1h};
constexpr LinkId link(unsigned n) {
    return static_cast<LinkId>(n);
}
constexpr ChannelId channel(unsigned n) {
    return static_cast<ChannelId>(n);
}

ChannelSet channels(std::initializer_list<unsigned> all) {
    ChannelSet set;
    for (const unsigned n : all) set.insert(channel(n));
    return set;
}

std::uint64_t key(const support::Bytes& frame) {
    return key_of(ano::FrameView{frame});
}

}    // namespace

TEST(KeyOf, tells_frames_apart) {
    const auto one = support::frame(1, 2, 3, {4});
    EXPECT_EQ(key(one), key(support::frame(1, 2, 3, {4})));
    for (const auto& other :
         {support::frame(9, 2, 3, {4}), support::frame(1, 9, 3, {4}), support::frame(1, 2, 9, {4}),
          support::frame(1, 2, 3, {9}), support::frame(1, 2, 3, {4, 0}), support::frame(1, 2, 3, {})})
        EXPECT_NE(key(one), key(other));
}

TEST(Recent, remembers_within_its_window) {
    Recent<int> recent{2s, 64};
    EXPECT_EQ(recent.find(0, start), nullptr);
    recent.put(0, 7, start);
    ASSERT_NE(recent.find(0, start + 2s - 1ns), nullptr);
    EXPECT_EQ(*recent.find(0, start), 7);
    EXPECT_EQ(recent.find(0, start + 2s), nullptr);
    recent.put(0, 8, start + 1s);
    EXPECT_EQ(*recent.find(0, start + 2s), 8);
}

TEST(Recent, forgets_the_oldest_when_full) {
    Recent<int> recent{1h, 8};
    for (int n = 0; n < 1000; ++n) recent.put(static_cast<std::uint64_t>(n), n, start + n * 1ms);
    int known = 0;
    for (int n = 0; n < 1000; ++n) known += recent.find(static_cast<std::uint64_t>(n), start + 1s) != nullptr;
    EXPECT_EQ(known, 8);
    EXPECT_NE(recent.find(999, start + 1s), nullptr);
}

TEST(LoopGuard, knows_what_comes_back) {
    LoopGuard guard;
    guard.remember(1, channel(60), ChannelSet{channel(3)} | channel(4), start);
    EXPECT_TRUE(guard.looped(1, channel(3), start + 1s));
    EXPECT_TRUE(guard.looped(1, channel(3), start + 1s)) << "every time";
    EXPECT_TRUE(guard.looped(1, channel(4), start + 1999ms));
    EXPECT_FALSE(guard.looped(1, channel(5), start + 1s)) << "it did not go there";
    EXPECT_FALSE(guard.looped(2, channel(3), start + 1s));
    EXPECT_FALSE(guard.looped(1, channel(3), start + 2s));
}

TEST(LoopGuard, a_channel_that_takes_over_a_number_starts_fresh) {
    LoopGuard guard;
    guard.remember(1, channel(60), channel(3), start);
    guard.open(channel(3), link(3), start + 1ms);
    EXPECT_FALSE(guard.looped(1, channel(3), start + 1s));
    guard.remember(1, channel(60), channel(3), start + 1s);
    EXPECT_TRUE(guard.looped(1, channel(3), start + 1s));
}

TEST(LoopGuard, knows_a_copy_by_whatever_way_it_comes) {
    LoopGuard guard;
    guard.remember(1, channel(0), channel(3), start);
    EXPECT_FALSE(guard.copied(1, channel(0), start + 1s)) << "its sender may repeat it";
    EXPECT_TRUE(guard.copied(1, channel(5), start + 1s));
    guard.remember(1, channel(5), channel(4), start + 1s);
    EXPECT_FALSE(guard.copied(1, channel(0), start + 1s)) << "it came first by this one";
    EXPECT_FALSE(guard.copied(2, channel(5), start + 1s));
    EXPECT_FALSE(guard.copied(1, channel(5), start + 3s));
    guard.open(channel(6), link(6), start + 1001ms);
    EXPECT_FALSE(guard.copied(1, channel(6), start + 2s)) << "a sender with a new port";
}

TEST(LoopGuard, takes_what_comes_as_a_channel_opens_for_that_channels_own) {
    LoopGuard guard;
    guard.open(channel(5), link(5), start);    // two hosts with new ports, in one batch
    guard.remember(1, channel(0), channel(5), start);
    EXPECT_FALSE(guard.copied(1, channel(5), start));
    EXPECT_FALSE(guard.looped(1, channel(5), start));
    EXPECT_TRUE(guard.copied(1, channel(6), start));
}

TEST(LoopGuard, a_sender_with_a_new_port_goes_on_saying_the_same) {
    LoopGuard guard;
    guard.open(channel(0), link(0), start);
    guard.open(channel(1), link(7), start);
    guard.remember(1, channel(0), channel(1), start + 1s);
    guard.open(channel(5), link(0), start + 2s);
    for (auto now = start + 2s; now < start + 4s; now += 10ms) {
        EXPECT_FALSE(guard.looped(1, channel(5), now) || guard.copied(1, channel(5), now));
        guard.remember(1, channel(5), channel(1), now);
        EXPECT_TRUE(guard.looped(1, channel(1), now)) << "it went there";
    }
}

TEST(LoopGuard, a_sender_that_repeats_itself_misses_one_in_a_thousand) {
    LoopGuard guard;
    int passed = 0;
    auto now = start;
    for (int i = 0; i < 10'000; ++i, now += 10ms) {
        if (guard.looped(1, channel(0), now)) continue;
        ++passed;
        guard.remember(1, channel(0), channel(3), now);
    }
    EXPECT_EQ(passed, 9991);
    now += 2s;
    for (int i = 0; i < 10'000; ++i, now += 2s) {
        EXPECT_FALSE(guard.looped(1, channel(0), now)) << "nobody goes round so slowly";
        guard.remember(1, channel(0), channel(3), now);
    }
}

// It comes back by the channel that it first came by: whatever brought it in did so elsewhere.
TEST(LoopGuard, a_ring_that_began_elsewhere_ends) {
    LoopGuard guard;
    auto now = start;
    int turns = 0;
    for (; turns < 100'000 && !guard.looped(1, channel(0), now); now += 500ms, ++turns)
        guard.remember(1, channel(0), channel(3), now);
    EXPECT_EQ(turns, 1000);
}

TEST(LoopGuard, lets_another_host_ask_the_same_once) {
    LoopGuard guard;
    guard.remember(1, channel(60), channels({0, 1}), start);
    EXPECT_FALSE(guard.looped(1, channel(1), start + 100ms, true));
    guard.remember(1, channel(60), channels({0}), start + 100ms);
    EXPECT_TRUE(guard.looped(1, channel(1), start + 1s, true)) << "and then it goes round";
    EXPECT_FALSE(guard.looped(1, channel(0), start + 1s, true)) << "one channel says nothing of another";
    EXPECT_FALSE(guard.suspect(channel(1), start + 1s)) << "two who ask all the time are no loop";
}

TEST(LoopGuard, a_device_that_comes_back_tells_of_questions_that_will) {
    LoopGuard guard;
    guard.remember(1, channel(60), channels({1}), start);
    EXPECT_TRUE(guard.looped(1, channel(1), start + 100ms));
    guard.remember(2, channel(60), channels({1}), start + 200ms);
    EXPECT_TRUE(guard.looped(2, channel(1), start + 300ms, true));
    guard.remember(3, channel(60), channels({1}), start + 61s);
    EXPECT_FALSE(guard.looped(3, channel(1), start + 61s, true)) << "not for ever";
    EXPECT_TRUE(guard.looped(3, channel(1), start + 62s));
    guard.open(channel(1), link(1), start + 62s);
    guard.remember(4, channel(60), channels({1}), start + 63s);
    EXPECT_FALSE(guard.looped(4, channel(1), start + 63s, true)) << "another channel by now";
}

TEST(LoopGuard, only_hosts_that_ask_everybody_say_what_others_say) {
    EXPECT_TRUE(asked_by_many(ano::FrameView{support::frame(0xFE, 0xFF, 0xE0, {0, 0, 0})}));
    EXPECT_TRUE(asked_by_many(ano::FrameView{support::frame(0xD2, 0xFF, 0xE0, {0, 0, 0})}));
    EXPECT_FALSE(asked_by_many(ano::FrameView{support::frame(0xDC, 0xFF, 0xE0, {0, 0, 0})}));
    EXPECT_FALSE(asked_by_many(ano::FrameView{support::frame(0xFE, 0xDC, 0xE0, {0, 0, 0})}));
    EXPECT_FALSE(asked_by_many(ano::FrameView{support::frame(0xFE, 0xFF, 0xC0, {0, 0, 0})}));
}

TEST(DuplicateGuard, lets_one_copy_through) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::nothing, start));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 500ms));
    EXPECT_TRUE(guard.duplicate(1, 1, link(2), Replaces::nothing, start + 1999ms));
    EXPECT_FALSE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 2s));
}

TEST(DuplicateGuard, the_same_link_may_repeat) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::nothing, start));
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::nothing, start + 1s));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 2500ms)) << "two seconds from the last";
}

TEST(DuplicateGuard, groups_are_apart) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(0xAB, 1, link(0), Replaces::nothing, start));
    EXPECT_FALSE(guard.duplicate(0xAB, 2, link(1), Replaces::nothing, start));
}

TEST(DuplicateGuard, resting_sticks_survive_a_failing_link) {
    DuplicateGuard guard;
    TimePoint now = start;
    for (int i = 0; i < 50; ++i, now += 20ms) {    // both links carry them
        EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::same_id, now));
        EXPECT_TRUE(guard.duplicate(1, 1, link(1), Replaces::same_id, now + 1ms));
    }
    int lost = 0;
    for (int i = 0; i < 50; ++i, now += 20ms) lost += guard.duplicate(1, 1, link(1), Replaces::same_id, now);
    EXPECT_LE(lost, 10) << "200 ms";
}

TEST(DuplicateGuard, a_command_never_comes_twice) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::nothing, start));
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::nothing, start + 100ms));    // the user's own repeat
    for (int i = 1; i < 10; ++i) EXPECT_TRUE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 100ms + i * 200ms));
}
