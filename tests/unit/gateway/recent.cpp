#include <gateway/recent.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

constexpr TimePoint start{1h};
constexpr LinkId link(unsigned n) { return static_cast<LinkId>(n); }
std::uint64_t key(const support::Bytes& frame) { return key_of(ano::FrameView{frame}); }

}    // namespace

TEST(KeyOf, tells_frames_apart) {
    const auto one = support::frame(1, 2, 3, {4});
    EXPECT_EQ(key(one), key(support::frame(1, 2, 3, {4})));
    for (const auto& other : {support::frame(9, 2, 3, {4}), support::frame(1, 9, 3, {4}), support::frame(1, 2, 9, {4}),
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

TEST(DuplicateGuard, lets_one_copy_through) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::nothing, start));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 500ms));
    EXPECT_TRUE(guard.duplicate(1, 1, link(2), Replaces::nothing, start + 1999ms));
    EXPECT_FALSE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 2s));
}

TEST(DuplicateGuard, a_copy_that_waited_to_be_read_is_one_all_the_same) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Replaces::nothing, start));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 4s, start + 1999ms));
    EXPECT_FALSE(guard.duplicate(1, 1, link(1), Replaces::nothing, start + 4s, start + 2s));
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
