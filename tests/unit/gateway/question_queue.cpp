#include <gateway/question_queue.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace anogate::question_queue_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;

constexpr std::uint8_t host = 0xFE, fc = 0xDC;
constexpr ano::TimePoint start{1h};

Bytes question(std::uint8_t number) { return support::frame(host, fc, 0xE0, {2, number, 0}); }

/// The maximum of questions to a device is unanswered; the next question waits.
class BusyDevice : public testing::Test {
protected:
    void SetUp() override {
        outbox.open();
        for (std::uint8_t n = 0; n < InFlight::max_questions; ++n) ask(n);
        ASSERT_EQ(send(start), InFlight::max_questions);
        ASSERT_EQ(queue.waiting(), 0u);
    }
    void ask(std::uint8_t number, ChannelId from = ourselves, ano::TimePoint now = start) {
        const Bytes frame = question(number);
        queue.push(ano::FrameView{frame}, policy_of(0xE0), now, from);
    }
    std::size_t send(ano::TimePoint now) {
        std::array<std::span<const std::uint8_t>, 16> pieces;
        const std::size_t count = outbox.gather(pieces, now);
        for (std::size_t i = 0; i < count; ++i) outbox.sent_frame();
        return count;
    }

    Outbox outbox{{.bytes = 1000, .max_data = 100, .age = {.control = 200ms, .telemetry = 1s, .rest = 5s}}};
    QuestionQueue queue{outbox, {.bytes = 1000, .age = 5s}};
};

TEST_F(BusyDevice, waiting_requests_age_while_the_machine_sleeps) {
    ask(8, ChannelId{0});
    ask(9, ChannelId{1});
    ask(10, ChannelId{0});
    queue.grow_older(5s);
    EXPECT_FALSE(queue.release(start));
    EXPECT_EQ(queue.waiting(), 0u);
    EXPECT_EQ(queue.counters().stale, 3u);
}

TEST_F(BusyDevice, a_waiting_request_keeps_only_the_time_that_remains_after_the_sleep) {
    ask(8);
    queue.grow_older(3s);
    queue.grow_older(1900ms);
    EXPECT_EQ(queue.next_look(start), start + 100ms);
    EXPECT_FALSE(queue.release(start + 99ms));
    EXPECT_EQ(queue.waiting(), 1u);
    EXPECT_FALSE(queue.release(start + 100ms));
    EXPECT_EQ(queue.counters().stale, 1u);
}

TEST_F(BusyDevice, a_request_received_after_the_sleep_does_not_age_by_it) {
    ask(8);
    queue.grow_older(5s);
    ask(9, ourselves, start + 1ms);    // this drops the other
    EXPECT_EQ(queue.counters().stale, 1u);
    EXPECT_EQ(queue.waiting(), 1u);
    EXPECT_TRUE(queue.release(start + InFlight::patience));
    EXPECT_EQ(send(start + InFlight::patience), 1u);
}

TEST_F(BusyDevice, a_request_that_waited_during_the_sleep_keeps_its_age_in_the_outbox) {
    ask(8);
    queue.grow_older(4s);
    EXPECT_TRUE(queue.release(start + InFlight::patience));
    EXPECT_EQ(send(start + 1s), 0u);
    EXPECT_EQ(outbox.counters().stale, 1u);
}

TEST_F(BusyDevice, a_request_as_large_as_the_queue_waits_there_alone) {
    const Bytes one = question(8), other = question(9);
    QuestionQueue small{outbox, {.bytes = one.size()}};
    for (std::uint8_t n = 0; n < InFlight::max_questions; ++n) small.push(ano::FrameView{one}, policy_of(0xE0), start);
    EXPECT_EQ(small.push(ano::FrameView{one}, policy_of(0xE0), start), nullptr);
    EXPECT_EQ(small.waiting(), 1u);
    EXPECT_EQ(small.push(ano::FrameView{other}, policy_of(0xE0), start), nullptr);
    EXPECT_EQ(small.waiting(), 1u);
    EXPECT_EQ(small.counters().queue_full, 1u);
}

}    // namespace
}    // namespace anogate::question_queue_tests
