// Whether a peer is another gateway's listening socket: who asks, answers and waits.
#include <gateway/peers/listener_check.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace anogate::listener_check_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using Kind = ListeningNotice::Kind;

const TimePoint start = TimePoint{} + 1h;
const Endpoint one = *Endpoint::parse("10.0.0.1:12333"), two = *Endpoint::parse("10.0.0.2:12333");

struct Check : ListenerCheck {
    explicit Check(std::uint64_t first) : ListenerCheck{[n = first]() mutable { return n++; }} {}
};

TEST(ListeningNotice, is_a_special_broadcast_frame_of_a_host) {
    const ListeningNotice notice{Kind::answer, 0x0123456789ABCDEF};
    const NoticeFrame bytes = frame_of(notice);
    ASSERT_TRUE(ano::frame_at(bytes));
    const ano::FrameView frame{bytes};
    EXPECT_EQ(frame.id(), 0xFB);
    EXPECT_EQ(frame.source(), 0xFE);
    EXPECT_EQ(frame.destination(), 0xFF);
    EXPECT_EQ(listening_notice(frame), notice);
}

TEST(ListeningNotice, is_not_recognized_in_other_frames) {
    NoticeFrame whole = frame_of({Kind::question, 1});
    const auto changed = [&](std::size_t at, std::uint8_t to) {
        NoticeFrame other = whole;
        other[at] = to;
        ano::seal(other);
        return listening_notice(ano::FrameView{other});
    };
    EXPECT_TRUE(changed(1, 0xFE));
    EXPECT_FALSE(changed(1, 0xDC));
    EXPECT_FALSE(changed(2, 0xDC));
    EXPECT_FALSE(changed(3, 0xFA));
    EXPECT_FALSE(changed(6, 'b'));
    EXPECT_FALSE(changed(10, 0));
    EXPECT_FALSE(changed(10, 3));
    const Bytes longer = support::frame(0xFE, 0xFF, 0xFB, Bytes(14, 1));
    EXPECT_FALSE(listening_notice(ano::FrameView{longer}));
}

TEST(ListenerCheck, a_suspect_is_queried_at_once_after_one_and_four_seconds_and_then_once_a_minute) {
    Check check{7};
    std::vector<Duration> asked;
    for (Duration t{}; t < 130s; t += 500ms)
        if (const auto question = check.question(two, start + t)) {
            EXPECT_EQ(*question, (ListeningNotice{Kind::question, 7}));
            asked.push_back(t);
        }
    EXPECT_EQ(asked, (std::vector<Duration>{0s, 1s, 4s, 64s, 124s}));
}

TEST(ListenerCheck, a_sender_that_repeats_the_number_is_a_listening_gateway_and_refused) {
    Check check{7};
    check.question(two, start);
    EXPECT_FALSE(check.answered(two, 8, start)) << "a guess";
    EXPECT_FALSE(check.answered(one, 7, start)) << "somebody else";
    EXPECT_FALSE(check.is_refused(two));
    EXPECT_TRUE(check.answered(two, 7, start));
    EXPECT_TRUE(check.is_refused(two));
    EXPECT_FALSE(check.answered(two, 7, start)) << "once";
    check.forget(two);
    EXPECT_TRUE(check.is_refused(two)) << "its channel is gone, the refusal stays";
}

TEST(ListenerCheck, a_sender_that_was_not_queried_is_not_refused) {
    Check check{7};
    EXPECT_FALSE(check.answered(two, 0, start));
    EXPECT_FALSE(check.answered(two, 7, start));
    check.asked(two, 5, start);
    EXPECT_FALSE(check.answered(two, 0, start));
    EXPECT_FALSE(check.is_refused(two));
}

TEST(ListenerCheck, a_request_is_answered_with_its_number_and_its_sender_is_suspended_a_second_once_a_minute) {
    Check check{7};
    EXPECT_EQ(check.asked(two, 99, start), (ListeningNotice{Kind::answer, 99}));
    EXPECT_TRUE(check.is_suspended(two, start + 1s - 1ns));
    EXPECT_FALSE(check.is_suspended(two, start + 1s));
    EXPECT_FALSE(check.is_suspended(one, start));
    check.asked(two, 99, start + 2s);
    EXPECT_FALSE(check.is_suspended(two, start + 2s)) << "or anybody could silence it";
    check.asked(two, 99, start + 60s);
    EXPECT_TRUE(check.is_suspended(two, start + 60s));
}

TEST(ListenerCheck, a_suspension_is_remembered_during_requests_of_others) {
    Check check{7};
    Duration suspended{};
    for (Duration t{}; t < 60s; t += 500ms) {
        check.asked(two, 99, start + t);
        if (check.is_suspended(two, start + t)) suspended += 500ms;
        for (std::uint8_t n = 0; n < 140; ++n) check.asked({IpAddress::v4(10, 1, 0, n), 5}, n, start + t);
        if (t == 10s) check.forget(two);
    }
    EXPECT_EQ(suspended, 1s);
    EXPECT_FALSE(check.is_suspended(one, start + 59s)) << "none is remembered any more, so nobody else is suspended";
    check.asked(one, 5, start + 59s);
    EXPECT_FALSE(check.is_suspended(one, start + 59s));
    check.asked(one, 5, start + 120s);
    EXPECT_TRUE(check.is_suspended(one, start + 120s));
}

TEST(ListenerCheck, an_echo_of_a_request_of_the_gateway_is_ignored) {
    Check check{7};
    check.question(two, start);
    EXPECT_FALSE(check.asked(two, 7, start));
    EXPECT_FALSE(check.is_suspended(two, start));
}

TEST(ListenerCheck, answers_each_question_and_asks_at_most_20_strangers_a_second) {
    Check check{7};
    int answers = 0, questions = 0;
    for (std::uint64_t n = 0; n < 1000; ++n) {
        const Endpoint from{IpAddress::v4(10, 0, static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n)), 5};
        if (check.asked(from, n, start)) ++answers;
        if (check.question_back(from, start)) ++questions;
    }
    EXPECT_EQ(answers, 1000) << "or strangers could prevent the answer to another gateway";
    EXPECT_EQ(questions, 20);
    EXPECT_TRUE(check.question_back(one, start + 1s));
}

TEST(ListenerCheck, thousands_of_strangers_displace_no_suspect_whose_answer_is_awaited) {
    Check check{7};
    const auto question = check.question(two, start);
    ASSERT_TRUE(question);
    for (std::uint64_t n = 0; n < 10000; ++n) {
        const Endpoint from{IpAddress::v4(10, 1, static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n)), 5};
        check.asked(from, n, start);
        check.question_back(from, start);
    }
    EXPECT_TRUE(check.answered(two, question->number, start + 10ms));
}

TEST(ListenerCheck, a_refused_sender_that_stops_answering_is_no_longer_refused) {
    Check check{7};
    check.question(two, start);
    check.answered(two, 7, start);
    TimePoint now = start;
    for (int i = 0; i < ListenerCheck::unanswered_enough; ++i) {
        now += 1s;
        EXPECT_TRUE(check.question_back(two, now)) << i;
        EXPECT_FALSE(check.question_back(two, now + 999ms)) << "one a second";
        EXPECT_TRUE(check.is_refused(two));
    }
    EXPECT_FALSE(check.question_back(two, now + 1s));
    EXPECT_FALSE(check.is_refused(two)) << "a udp link at that port is welcome";
}

TEST(ListenerCheck, a_refused_sender_that_keeps_answering_stays_refused) {
    Check check{7};
    check.question(two, start);
    check.answered(two, 7, start);
    for (int i = 1; i < 30; ++i) {
        const auto question = check.question_back(two, start + i * 1s);
        ASSERT_TRUE(question);
        EXPECT_TRUE(check.answered(two, question->number, start + i * 1s));
    }
    EXPECT_TRUE(check.is_refused(two));
}

TEST(ListenerCheck, thousands_of_strangers_displace_no_refused_sender) {
    Check check{7};
    check.question(two, start);
    check.answered(two, 7, start);
    for (std::uint64_t n = 0; n < 10000; ++n)
        check.asked({IpAddress::v4(10, 1, static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n)), 5}, n, start + 1s);
    EXPECT_TRUE(check.is_refused(two));
}

// Frames of one reach the other in the order in which they were sent. A forged frame made `there` a peer of the first gateway
// only, which is about to send: frames sent after its question are dropped, and both reject each other.
TEST(ListenerCheck, two_gateways_refuse_each_other_whichever_starts) {
    Check a{100}, b{200};
    const auto question = a.question(two, start);
    ASSERT_TRUE(question);
    const auto answer = b.asked(one, question->number, start);
    ASSERT_TRUE(answer);
    EXPECT_TRUE(b.is_suspended(one, start)) << "the command right behind it";
    const auto back = b.question_back(one, start);
    ASSERT_TRUE(back);
    EXPECT_TRUE(a.answered(two, answer->number, start));
    const auto last = a.asked(two, back->number, start);
    ASSERT_TRUE(last);
    EXPECT_TRUE(b.answered(one, last->number, start));
    EXPECT_TRUE(a.is_refused(two) && b.is_refused(one));
}

}    // namespace
}    // namespace anogate::listener_check_tests
