#include <gtest/gtest.h>
#include <device/reply.hpp>

#include <support/bytes.hpp>

namespace reply_tests {
namespace {

using ano::FrameView;
using ano::device::Outcome;
using ano::device::Outgoing;
using ano::device::Reply;
using support::Bytes;
using support::frame;

const Bytes write = frame(0xFE, 0x21, 0xE1, {0, 0, 1});

TEST(Reply, is_sent_only_once) {
    Outgoing out;
    Reply reply{FrameView{write}, 5, 0x21, out};
    EXPECT_EQ(reply.acknowledge(), Outcome::answered);
    EXPECT_EQ(reply.acknowledge(), Outcome::answered);
    ano::Draft<"parameter_value"> value;
    EXPECT_EQ(reply.send(value), Outcome::answered);
    EXPECT_EQ(out.waiting(), 1u);
    const auto departure = out.next();
    ASSERT_TRUE(departure);
    EXPECT_EQ(departure->link, 5u);
    EXPECT_EQ(departure->frame.id(), 0x00);
    EXPECT_EQ(reply.lost(), 0u);
}

TEST(Reply, is_not_sent_for_messages_that_are_not_acknowledged) {
    Outgoing out;
    for (const std::uint8_t id : Bytes{0x00, 0x40, 0x41, 0x60, 0xC1, 0xF0}) {
        const Bytes request = frame(0xFE, 0x21, id, Bytes(22));
        Reply reply{FrameView{request}, 0, 0x21, out};
        EXPECT_EQ(reply.acknowledge(), Outcome::unanswered) << int{id};
    }
    EXPECT_EQ(out.waiting(), 0u);
}

TEST(Reply, is_lost_when_the_queue_is_full) {
    Outgoing out;
    for (std::size_t i = 0; i <= Outgoing::max_frames; ++i) {
        Reply reply{FrameView{write}, 0, 0x21, out};
        EXPECT_EQ(reply.acknowledge(), Outcome::answered);
        EXPECT_EQ(reply.lost(), i == Outgoing::max_frames ? 1u : 0u);
    }
    EXPECT_EQ(out.waiting(), Outgoing::max_frames);
}

TEST(Reply, is_padded_with_zeros_for_a_longer_layout) {
    Outgoing out;
    Reply reply{FrameView{write}, 0, 0x21, out};
    ano::Draft<"command_query"> count;
    ASSERT_TRUE(count.set<"val">(3));
    reply.send(count, 2);
    const auto departure = out.next();
    ASSERT_TRUE(departure);
    const auto bytes = departure->frame.bytes();
    EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), frame(0x21, 0xFE, 0xC1, {0, 3, 0, 0, 0}));
}

}    // namespace
}    // namespace reply_tests
