#include <gateway/in_flight.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace in_flight_tests {
namespace {

constexpr ano::TimePoint start{1h};
constexpr std::uint8_t host = 0xFE, fc = 0xDC, everybody = 0xFF;
constexpr ChannelId one{1}, other{2};

Bytes ask(std::uint8_t id, const Bytes& data, std::uint8_t to = fc) { return support::frame(host, to, id, data); }
Bytes reply(std::uint8_t id, const Bytes& data, std::uint8_t from = fc) { return support::frame(from, host, id, data); }

struct Exchange {
    Bytes question;
    Bytes answer;
    Bytes of_another;    // with the same id if there is one: it answers another question
};
const Exchange exchanges[] = {
    {ask(0xE0, {0, 0, 0}), reply(0xE3, {fc, 100, 0, 100, 0, 0, 0, 32, 3}), reply(0xE0, {1, 40, 0})},
    {ask(0xE0, {1, 0, 0}), reply(0xE0, {1, 40, 0}), reply(0xE0, {0x10, 0xAB, 0})},
    {ask(0xE0, {2, 7, 1}), reply(0xE1, {7, 1, 42}), reply(0xE1, {7, 0, 42})},
    {ask(0xE0, {3, 7, 1}), reply(0xE2, {7, 1, 8, 'P'}), reply(0xE2, {8, 1, 8, 'P'})},
    {ask(0xC1, {0, 0, 0}), reply(0xC1, {0, 12, 0}), reply(0xC1, {1, 12, 0})},
    {ask(0xC1, {1, 5, 0}), reply(0xC2, {5, 0, 1, 2, 3}), reply(0xC2, {6, 0, 1, 2, 3})},
    {ask(0x60, {0xFF}), reply(0x60, {9}), reply(0x61, Bytes(22))},
    {ask(0x60, {3}), reply(0x61, {3, 0, 0}), reply(0x61, {4, 0, 0})},
};

ano::FrameView view(const Bytes& bytes) { return ano::FrameView{bytes}; }

TEST(Question, is_recognized_with_its_answer) {
    for (const Exchange& e : exchanges) {
        const auto question = question_in(view(e.question));
        ASSERT_TRUE(question) << testing::PrintToString(e.question);
        EXPECT_TRUE(answers(view(e.answer), *question)) << testing::PrintToString(e.answer);
        EXPECT_FALSE(answers(view(e.of_another), *question)) << testing::PrintToString(e.of_another);
        for (const Exchange& another : exchanges)
            EXPECT_TRUE(&another == &e || !answers(view(another.answer), *question)) << testing::PrintToString(another.answer);
    }
}

TEST(Question, is_not_a_frame_that_writes_commands_or_streams) {
    for (const Bytes& frame :
         {ask(0xC0, {1, 1, 1}), ask(0x40, Bytes(20)), ask(0x41, Bytes(14)), ask(0xE0, {0x10, 0xAB, 0}), ask(0xE1, {7, 0, 42}),
          ask(0x61, Bytes(22)), ask(0xF0, {1}), ask(0x03, Bytes(7)), ask(0x00, {0xC0, 1, 2})})
        EXPECT_FALSE(question_in(view(frame))) << testing::PrintToString(frame);
}

TEST(Question, is_not_a_frame_that_is_too_short) {
    for (const Bytes& frame : {ask(0xE0, {0, 0}), ask(0xC1, {}), ask(0x60, {}), ask(0xC1, {2, 0, 0})})
        EXPECT_FALSE(question_in(view(frame))) << testing::PrintToString(frame);
    EXPECT_TRUE(question_in(view(ask(0xE0, {0, 0, 0, 0, 0})))) << "longer is legal";
}

TEST(Question, is_not_an_answer_on_its_way_to_a_host) {
    for (const Exchange& e : exchanges) EXPECT_FALSE(question_in(view(e.answer))) << testing::PrintToString(e.answer);
}

TEST(Question, to_all_devices_may_be_answered_by_any_device_and_to_one_device_only_by_that_one) {
    const auto all = question_in(view(ask(0xE0, {0, 0, 0}, everybody)));
    const auto port = question_in(view(ask(0xE0, {0, 0, 0}, 5)));
    const auto single = question_in(view(ask(0xE0, {0, 0, 0})));
    ASSERT_TRUE(all && port && single);
    const Bytes flow = reply(0xE3, Bytes(9), 0xDE);
    EXPECT_TRUE(answers(view(flow), *all));
    EXPECT_TRUE(answers(view(flow), *port)) << "whatever is behind it";
    EXPECT_FALSE(answers(view(flow), *single));
}

Bytes value_of(std::uint8_t n) { return ask(0xE0, {2, n, 0}); }
Bytes value(std::uint8_t n) { return reply(0xE1, {n, 0, 1}); }

struct Flight : testing::Test {
    void send(const Bytes& frame, ano::TimePoint now, ChannelId from = ourselves) {
        flight.queued(view(frame), from);
        flight.left(view(frame), now);
    }
    bool has_room(ano::TimePoint now) {
        flight.expire(now);
        return flight.has_place(ourselves);
    }
    InFlight flight;
};

TEST_F(Flight, at_most_eight_requests_are_open_until_one_is_answered) {
    for (std::uint8_t n = 0; n < 8; ++n) {
        EXPECT_TRUE(has_room(start));
        send(value_of(n), start);
    }
    EXPECT_FALSE(has_room(start));
    EXPECT_FALSE(flight.receive(view(value(8)))) << "nobody asked";
    EXPECT_FALSE(has_room(start));
    EXPECT_TRUE(flight.receive(view(value(3))));
    EXPECT_TRUE(has_room(start));
    EXPECT_FALSE(flight.receive(view(value(3)))) << "once";
    EXPECT_EQ(flight.size(), 7u);
}

TEST_F(Flight, requests_expire_half_a_second_after_they_were_sent) {
    flight.queued(view(value_of(1)), ourselves);
    EXPECT_EQ(flight.next_expiry(), std::nullopt) << "it waits in the outbox, maybe for long";
    for (std::uint8_t n = 2; n < 9; ++n) send(value_of(n), start + 10ms * n);
    EXPECT_EQ(flight.next_expiry(), start + 520ms);
    EXPECT_FALSE(has_room(start + 519ms));
    EXPECT_TRUE(has_room(start + 520ms));
    EXPECT_EQ(flight.size(), 7u);
    EXPECT_TRUE(has_room(start + 1h));
    EXPECT_EQ(flight.size(), 1u) << "what waits to leave is not forgotten";
}

TEST_F(Flight, an_answer_completes_the_older_of_two_equal_requests) {
    send(value_of(1), start);
    send(value_of(1), start + 100ms);
    EXPECT_TRUE(flight.receive(view(value(1))));
    EXPECT_EQ(flight.next_expiry(), start + 600ms);
}

TEST_F(Flight, a_request_dropped_before_it_was_sent_needs_no_answer) {
    flight.queued(view(value_of(1)), ourselves);
    EXPECT_FALSE(flight.receive(view(value(1)))) << "it was not asked yet";
    flight.dropped(view(value_of(1)));
    EXPECT_EQ(flight.size(), 0u);
    flight.left(view(value_of(1)), start);
    EXPECT_EQ(flight.size(), 0u);
}

TEST_F(Flight, other_frames_are_ignored) {
    const Bytes command = ask(0xC0, {1, 1, 1});
    send(command, start);
    EXPECT_EQ(flight.size(), 0u);
}

TEST_F(Flight, one_request_is_reserved_for_the_gateway) {
    for (std::uint8_t n = 0; n < 7; ++n) {
        EXPECT_TRUE(flight.has_place(one));
        send(value_of(n), start, n % 2 == 0 ? one : other);
    }
    EXPECT_FALSE(flight.has_place(one));
    EXPECT_FALSE(flight.has_place(other));
    EXPECT_TRUE(flight.has_place(ourselves));
    send(value_of(7), start, ourselves);
    EXPECT_FALSE(flight.has_place(ourselves));
    EXPECT_TRUE(flight.receive(view(value(0))));
    EXPECT_TRUE(flight.has_place(other)) << "the gateway has its place";
}

TEST_F(Flight, the_oldest_request_of_a_sender_with_several_expires_after_a_tenth_of_a_second) {
    send(value_of(1), start, one);
    EXPECT_EQ(flight.next_early(), std::nullopt);
    EXPECT_FALSE(flight.expire_one(start + 499ms)) << "its only one";
    send(value_of(2), start + 50ms, other);
    send(value_of(3), start + 60ms, other);
    EXPECT_EQ(flight.next_early(), start + 150ms);
    EXPECT_FALSE(flight.expire_one(start + 149ms));
    EXPECT_TRUE(flight.expire_one(start + 150ms));
    EXPECT_EQ(flight.places(other), 1u);
    EXPECT_EQ(flight.places(one), 1u);
    EXPECT_FALSE(flight.receive(view(value(2))));
    EXPECT_FALSE(flight.expire_one(start + 499ms));
}

TEST_F(Flight, a_request_sent_at_the_minimum_time_is_expired) {
    send(value_of(1), ano::TimePoint::min());
    EXPECT_TRUE(has_room(start));
    EXPECT_EQ(flight.size(), 0u);
}

}    // namespace
}    // namespace in_flight_tests
