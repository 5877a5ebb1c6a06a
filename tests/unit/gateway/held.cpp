#include <gateway/held.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace held_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

constexpr TimePoint start{1h};
constexpr ChannelId a{1}, b{2};

support::Bytes numbered(std::uint8_t n) { return support::frame(0xFE, 0xFF, 0xC0, {n}); }
support::Bytes taken(const std::optional<Held::Frame>& frame) {
    if (!frame) return {};
    return {frame->view().bytes().begin(), frame->view().bytes().end()};
}

TEST(Held, gives_back_in_order_what_is_due) {
    Held held;
    EXPECT_FALSE(held.due());
    EXPECT_TRUE(held.put(a, ano::FrameView{numbered(1)}, start));
    EXPECT_TRUE(held.put(b, ano::FrameView{numbered(2)}, start + 1s));
    EXPECT_EQ(held.due(), start);
    EXPECT_EQ(held.due(b), start + 1s);
    EXPECT_FALSE(held.due(ChannelId{3}));
    EXPECT_FALSE(held.take(start - 1ns));
    EXPECT_EQ(taken(held.take(start)), numbered(1));
    EXPECT_FALSE(held.take(start));
    EXPECT_EQ(taken(held.take(start + 1s)), numbered(2));
    EXPECT_TRUE(held.empty());
}

TEST(Held, what_is_due_does_not_wait_for_another_channel) {
    Held held;
    held.put(a, ano::FrameView{numbered(1)}, start + 1s);
    held.put(b, ano::FrameView{numbered(2)}, start);
    held.put(b, ano::FrameView{numbered(3)}, start);
    EXPECT_EQ(held.due(), start);
    EXPECT_EQ(taken(held.take(start)), numbered(2));
    EXPECT_EQ(taken(held.take(start)), numbered(3));
    EXPECT_EQ(held.due(), start + 1s);
    EXPECT_FALSE(held.take(b));
    EXPECT_EQ(taken(held.take(a)), numbered(1));
}

TEST(Held, a_channel_goes_on_when_it_brings_one_more_of_the_same) {
    Held held;
    held.put(a, ano::FrameView{numbered(1)}, start + 1s, {2, start + 100ms});
    EXPECT_FALSE(held.goes_on(a, ano::FrameView{numbered(1)}, start)) << "two may wait";
    EXPECT_TRUE(held.goes_on(a, ano::FrameView{numbered(1)}, start + 101ms)) << "it came too late for that";
    held.put(a, ano::FrameView{numbered(2)}, start + 1s);
    held.put(a, ano::FrameView{numbered(1)}, start + 1s);
    EXPECT_TRUE(held.goes_on(a, ano::FrameView{numbered(1)}, start));
    EXPECT_FALSE(held.goes_on(a, ano::FrameView{numbered(2)}, start)) << "it waits for another reason";
    EXPECT_FALSE(held.goes_on(b, ano::FrameView{numbered(1)}, start));
}

TEST(Held, has_room_for_a_few_short_ones) {
    Held held;
    const auto of_size = [](std::size_t size) { return support::frame(1, 2, 3, support::Bytes(size - ano::overhead, 0)); };
    EXPECT_FALSE(held.put(a, ano::FrameView{of_size(Held::max_frame_size + 1)}, start));
    EXPECT_TRUE(held.put(a, ano::FrameView{of_size(Held::max_frame_size)}, start));
    EXPECT_EQ(taken(held.take(start)), of_size(Held::max_frame_size));
    for (std::size_t i = 0; i < Held::max_frames; ++i) EXPECT_TRUE(held.put(i % 2 ? a : b, ano::FrameView{numbered(1)}, start));
    EXPECT_FALSE(held.put(a, ano::FrameView{numbered(1)}, start));
    EXPECT_EQ(held.forget(a), Held::max_frames / 2);
    std::size_t left = 0;
    while (const auto frame = held.take(start)) {
        EXPECT_EQ(frame->from, b);
        ++left;
    }
    EXPECT_EQ(left, Held::max_frames / 2);
}

}    // namespace
}    // namespace held_tests
