#include <gateway/channel.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>

using namespace anogate;

TEST(Channel, received_is_what_its_parsers_and_the_gateway_counted) {
    Channel channel{{}, {}, "", {}, {}, {}};
    channel.routed.no_route = 2;
    channel.routed.looped = 1;
    channel.beside.frames_in = 4;
    const auto bytes = support::frame(0xDC, 0xFE, 0x03, {1, 2, 3});
    auto room = channel.parser.prepare();
    room[0] = 0x55;
    std::copy(bytes.begin(), bytes.end(), room.begin() + 1);
    channel.parser.commit(bytes.size() + 1, {});
    while (channel.parser.next()) {}
    const ReceiveCounters all = channel.received();
    EXPECT_EQ(all.frames_in, 1u + 4u);
    EXPECT_EQ(all.bytes_in, bytes.size() + 1);
    EXPECT_EQ(all.skipped_bytes, 1u);
    EXPECT_EQ(all.no_route, 2u);
    EXPECT_EQ(all.looped, 1u);
}

TEST(Channel, sent_is_what_the_outbox_and_the_questions_before_it_counted) {
    Channel channel{{}, {}, "", {}, {}, {}};
    channel.outbox.open();
    channel.questions = std::make_unique<QuestionQueue>(channel.outbox, QuestionQueue::Options{});
    const auto question = support::frame(0xFE, 0xDC, 0xE0, {2, 0, 0});
    for (std::size_t n = 0; n < InFlight::most + 3; ++n) channel.questions->push(ano::FrameView{question}, policy_of(0xE0), {});
    EXPECT_EQ(channel.sent().offered, InFlight::most + 3);
    EXPECT_EQ(channel.waiting(), InFlight::most + 3);
}
