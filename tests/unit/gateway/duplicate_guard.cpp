#include <gateway/duplicate_guard.hpp>

#include <gtest/gtest.h>

namespace duplicate_guard_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

using Kind = DuplicateGuard::Kind;
constexpr TimePoint start{1h};
constexpr LinkId link(unsigned n) { return static_cast<LinkId>(n); }

TEST(DuplicateGuard, forwards_only_the_first_copy_within_two_seconds) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::other, start));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::other, start + 500ms));
    EXPECT_TRUE(guard.duplicate(1, 1, link(2), Kind::other, start + 1999ms));
    EXPECT_FALSE(guard.duplicate(1, 1, link(1), Kind::other, start + 2s));
}

TEST(DuplicateGuard, a_copy_that_waited_to_be_read_is_still_a_duplicate) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::other, start));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::other, start + 4s, start + 1999ms));
    EXPECT_FALSE(guard.duplicate(1, 1, link(1), Kind::other, start + 4s, start + 2s));
}

TEST(DuplicateGuard, restored_after_a_restart_knows_the_earlier_frames) {
    DuplicateGuard before;
    before.duplicate(0x100, 7, link(3), Kind::other, start);
    before.duplicate(0x200, 7, link(3), Kind::other, start + 1s);
    before.duplicate(0x300, 7, link(4), Kind::other, start + 1s);
    const auto brought = before.brought_by(link(3), start);
    ASSERT_EQ(brought.size(), 1u) << "the others are too old, or another's";
    EXPECT_EQ(brought[0].at, start + 1s);
    DuplicateGuard guard;
    guard.restore(brought[0], 2, link(0));    // the numbers differ now
    EXPECT_TRUE(guard.duplicate(0x200, 2, link(1), Kind::other, start + 2s));
    EXPECT_FALSE(guard.duplicate(0x300, 2, link(1), Kind::other, start + 2s));
    EXPECT_FALSE(guard.duplicate(0x200, 7, link(2), Kind::other, start + 2s)) << "of another group";
    EXPECT_FALSE(guard.duplicate(0x200, 2, link(1), Kind::other, start + 3s)) << "the window is over";
}

TEST(DuplicateGuard, passes_repeated_frames_of_the_same_link) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::other, start));
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::other, start + 1s));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::other, start + 2500ms)) << "two seconds from the last";
}

// Acknowledgements of equal commands are equal, and each command may be sent on another link.
TEST(DuplicateGuard, an_answer_to_a_newer_request_is_not_a_duplicate) {
    DuplicateGuard guard;
    guard.asked(1, start);
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::answer, start + 5ms));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::answer, start + 6ms));
    guard.asked(2, start + 300ms);
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::answer, start + 305ms)) << "another group was asked";
    guard.asked(1, start + 400ms);
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::other, start + 404ms)) << "a command is none";
    EXPECT_FALSE(guard.duplicate(1, 1, link(1), Kind::answer, start + 405ms));
    EXPECT_TRUE(guard.duplicate(1, 1, link(0), Kind::answer, start + 406ms));
}

TEST(DuplicateGuard, groups_are_independent) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(0xAB, 1, link(0), Kind::other, start));
    EXPECT_FALSE(guard.duplicate(0xAB, 2, link(1), Kind::other, start));
}

TEST(DuplicateGuard, unchanged_stick_frames_continue_within_200_ms_when_a_link_fails) {
    DuplicateGuard guard;
    TimePoint now = start;
    for (int i = 0; i < 50; ++i, now += 20ms) {    // both links deliver them
        EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::state, now));
        EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::state, now + 1ms));
    }
    int lost = 0;
    for (int i = 0; i < 50; ++i, now += 20ms) lost += guard.duplicate(1, 1, link(1), Kind::state, now);
    EXPECT_LE(lost, 10) << "200 ms";
}

TEST(DuplicateGuard, copies_of_a_command_by_another_link_never_pass) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::other, start));
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::other, start + 100ms));    // a repeat by the user
    for (int i = 1; i < 10; ++i) EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::other, start + 100ms + i * 200ms));
}

TEST(DuplicateGuard, copies_of_frames_of_a_removed_link_are_still_dropped) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::other, start));
    guard.remove_link(link(0));
    EXPECT_TRUE(guard.duplicate(1, 1, link(1), Kind::other, start + 1s)) << "a command never comes twice";
    EXPECT_TRUE(guard.duplicate(1, 1, link(0), Kind::other, start + 1s)) << "nor by another of this number";
}

TEST(DuplicateGuard, a_link_that_is_removed_counts_as_silent) {
    DuplicateGuard guard;
    for (int i = 0; i < 2; ++i) EXPECT_FALSE(guard.duplicate(1, 1, link(0), Kind::state, start));
    guard.remove_link(link(0));
    EXPECT_FALSE(guard.duplicate(1, 1, link(1), Kind::state, start + 1ms));
}

TEST(DuplicateGuard, a_removed_group_leaves_nothing_to_a_new_group_with_its_number) {
    DuplicateGuard guard;
    EXPECT_FALSE(guard.duplicate(0xAB, 1, link(0), Kind::other, start));
    EXPECT_FALSE(guard.duplicate(0xAB, 2, link(2), Kind::other, start));
    guard.remove_group(1);
    EXPECT_FALSE(guard.duplicate(0xAB, 1, link(1), Kind::other, start));
    EXPECT_TRUE(guard.duplicate(0xAB, 2, link(3), Kind::other, start));
}

}    // namespace
}    // namespace duplicate_guard_tests
