#include <gateway/channel.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

namespace channel_tests {

using namespace anogate;

TEST(Channel, received_sums_the_counters_of_its_parsers_and_the_gateway) {
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

TEST(Channel, sent_sums_the_counters_of_the_outbox_and_the_request_queue) {
    Channel channel{{}, {}, "", {}, {}, {}};
    channel.outbox.open();
    channel.questions = std::make_unique<QuestionQueue>(channel.outbox, QuestionQueue::Options{});
    const auto question = support::frame(0xFE, 0xDC, 0xE0, {2, 0, 0});
    for (std::size_t n = 0; n < InFlight::max_questions + 3; ++n)
        channel.questions->push(ano::FrameView{question}, policy_of(0xE0), {});
    EXPECT_EQ(channel.sent().offered, InFlight::max_questions + 3);
    EXPECT_EQ(channel.waiting(), InFlight::max_questions + 3);
}

TEST(Channel, counts_skipped_bytes_since_the_last_valid_frame) {
    Channel channel{{}, {}, "", {}, {}, {}};
    const auto bring = [&](const support::Bytes& bytes) {
        std::copy(bytes.begin(), bytes.end(), channel.parser.prepare().begin());
        channel.parser.commit(bytes.size(), {});
        while (channel.parser.next()) channel.record_received(ano::TimePoint{std::chrono::hours{1}});
    };
    bring(support::Bytes(5, 0x55));
    EXPECT_EQ(channel.skipped_since_heard(), 5u);
    bring(support::frame(0xDC, 0xFE, 0x03, {1, 2, 3}));
    EXPECT_EQ(channel.skipped_since_heard(), 0u);
    EXPECT_EQ(channel.heard_at, ano::TimePoint{std::chrono::hours{1}});
    bring(support::Bytes(3, 0x55));
    channel.beside.skipped_bytes = 2;
    EXPECT_EQ(channel.skipped_since_heard(), 3u + 2u);
}

}    // namespace channel_tests
