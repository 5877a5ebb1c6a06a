#include <gateway/outbox.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <array>

using namespace anogate;
using support::Bytes;

namespace {

using Piece = std::span<const std::uint8_t>;

Bytes numbered(std::uint8_t n, std::size_t data = 4) {
    return support::frame(0xDC, 0xFE, 0xF1, Bytes(data, n));
}

Outbox open_outbox(std::size_t bytes, std::size_t max_data) {
    Outbox outbox{{.bytes = bytes, .max_data = max_data}};
    outbox.open();
    return outbox;
}

void push(Outbox& outbox, const Bytes& frame) {
    outbox.push(ano::FrameView{frame});
}

Bytes gathered(const Outbox& outbox) {
    std::array<Piece, 64> pieces;
    Bytes all;
    const std::size_t count = outbox.gather(pieces);
    for (std::size_t i = 0; i < count; ++i) all.insert(all.end(), pieces[i].begin(), pieces[i].end());
    return all;
}

Bytes joined(std::initializer_list<Bytes> frames) {
    Bytes all;
    for (const Bytes& frame : frames) all.insert(all.end(), frame.begin(), frame.end());
    return all;
}

void expect_balanced(const Outbox& outbox) {
    EXPECT_EQ(unaccounted(outbox.counters()), outbox.waiting());
}

}    // namespace

TEST(Outbox, first_in_first_out) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1));
    push(outbox, numbered(2));
    EXPECT_EQ(outbox.waiting(), 2u);
    EXPECT_EQ(outbox.waiting_bytes(), 24u);
    EXPECT_EQ(gathered(outbox), joined({numbered(1), numbered(2)}));
    outbox.sent(24);
    EXPECT_TRUE(outbox.empty());
    EXPECT_EQ(outbox.counters().frames_out, 2u);
    EXPECT_EQ(outbox.counters().bytes_out, 24u);
    expect_balanced(outbox);
}

TEST(Outbox, gathers_as_many_as_there_is_room_for) {
    Outbox outbox = open_outbox(1000, 100);
    for (std::uint8_t n = 0; n < 5; ++n) push(outbox, numbered(n));
    std::array<Piece, 3> pieces;
    EXPECT_EQ(outbox.gather(pieces), 3u);
    EXPECT_EQ(outbox.gather({}), 0u);
}

TEST(Outbox, partial_send_continues_inside_the_frame) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1));
    push(outbox, numbered(2));
    outbox.sent(15);
    const Bytes all = joined({numbered(1), numbered(2)});
    EXPECT_EQ(gathered(outbox), Bytes(all.begin() + 15, all.end()));
    EXPECT_EQ(outbox.waiting(), 1u);
    expect_balanced(outbox);
    outbox.sent(9);
    EXPECT_TRUE(outbox.empty());
}

TEST(Outbox, full_drops_the_oldest) {
    Outbox outbox = open_outbox(30, 20);    // two frames of 12
    for (std::uint8_t n = 1; n <= 3; ++n) push(outbox, numbered(n));
    EXPECT_EQ(gathered(outbox), joined({numbered(2), numbered(3)}));
    EXPECT_EQ(outbox.counters().queue_full, 1u);
    expect_balanced(outbox);
}

TEST(Outbox, frame_that_has_begun_to_leave_is_never_dropped) {
    Outbox outbox = open_outbox(30, 20);
    push(outbox, numbered(1));
    push(outbox, numbered(2));
    outbox.sent(1);
    push(outbox, numbered(3));
    push(outbox, numbered(4, 20));    // alone as large as the bound allows
    const Bytes begun = numbered(1);
    EXPECT_EQ(gathered(outbox), joined({Bytes(begun.begin() + 1, begun.end()), numbered(4, 20)}));
    EXPECT_EQ(outbox.counters().queue_full, 2u);
    expect_balanced(outbox);
}

TEST(Outbox, datagrams_leave_or_fail_one_by_one) {
    Outbox outbox = open_outbox(1000, 100);
    for (std::uint8_t n = 1; n <= 3; ++n) push(outbox, numbered(n));
    outbox.sent_frame();
    outbox.drop_frame(&SendCounters::send_failed);
    EXPECT_EQ(gathered(outbox), numbered(3));
    EXPECT_EQ(outbox.counters().frames_out, 1u);
    EXPECT_EQ(outbox.counters().send_failed, 1u);
    expect_balanced(outbox);
}

TEST(Outbox, closed_takes_nothing_and_closing_empties) {
    Outbox outbox{{.bytes = 1000, .max_data = 100}};
    push(outbox, numbered(1));
    EXPECT_TRUE(outbox.empty());
    EXPECT_EQ(outbox.counters().link_down, 1u);
    outbox.open();
    push(outbox, numbered(2));
    push(outbox, numbered(3));
    outbox.sent(1);
    outbox.close();
    EXPECT_TRUE(outbox.empty());
    EXPECT_EQ(outbox.counters().link_down, 3u);
    expect_balanced(outbox);
    outbox.open();
    push(outbox, numbered(4));
    EXPECT_EQ(gathered(outbox), numbered(4)) << "whole: what had begun to leave is over";
}

TEST(Outbox, more_data_than_the_link_carries_is_too_big) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1, 101));
    EXPECT_TRUE(outbox.empty());
    EXPECT_EQ(outbox.counters().too_big, 1u);
    push(outbox, numbered(1, 100));
    EXPECT_EQ(outbox.waiting(), 1u);
    expect_balanced(outbox);
}

TEST(Outbox, counts_frames_without_data) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1, 0));
    push(outbox, numbered(1, 1));
    outbox.sent(outbox.waiting_bytes());
    EXPECT_EQ(outbox.counters().empty_out, 1u);
    EXPECT_EQ(outbox.counters().frames_out, 2u);
}
