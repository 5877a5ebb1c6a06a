#include <gateway/in_flight.hpp>
#include <gateway/outbox.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

namespace outbox_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

constexpr QueuePolicy command{TrafficClass::urgent, Replaces::nothing, AgeKind::rest};
constexpr QueuePolicy stick{TrafficClass::urgent, Replaces::same_id, AgeKind::control};
constexpr QueuePolicy attitude{TrafficClass::telemetry, Replaces::same_id, AgeKind::telemetry};
constexpr QueuePolicy ranging{TrafficClass::telemetry, Replaces::same_first_byte, AgeKind::telemetry};
constexpr QueuePolicy text{TrafficClass::telemetry, Replaces::nothing, AgeKind::telemetry};
constexpr QueuePolicy image{TrafficClass::bulk, Replaces::nothing, AgeKind::rest};
constexpr ano::TimePoint start{1h};

using Piece = std::span<const std::uint8_t>;

Bytes numbered(std::uint8_t n, std::size_t data = 4) { return support::frame(0xDC, 0xFE, 0xF1, Bytes(data, n)); }

Outbox open_outbox(std::size_t bytes, std::size_t max_data) {
    Outbox outbox{{.bytes = bytes, .max_data = max_data}};
    outbox.open();
    return outbox;
}

void push(Outbox& outbox, const Bytes& frame, QueuePolicy policy = {}) { outbox.push(ano::FrameView{frame}, policy, start); }

void push(Outbox& outbox, const Bytes& frame, QueuePolicy policy, std::uint8_t channel) {
    outbox.push(ano::FrameView{frame}, policy, start, ChannelId{channel});
}

Bytes from(std::uint8_t source, std::uint8_t n) { return support::frame(source, 0xFE, 0xF1, Bytes(4, n)); }

Bytes gathered(Outbox& outbox, ano::TimePoint now = start, std::size_t budget = SIZE_MAX) {
    std::array<Piece, 64> pieces;
    Bytes all;
    const std::size_t count = outbox.gather(pieces, now, budget);
    for (std::size_t i = 0; i < count; ++i) all.insert(all.end(), pieces[i].begin(), pieces[i].end());
    return all;
}

Bytes joined(std::initializer_list<Bytes> frames) {
    Bytes all;
    for (const Bytes& frame : frames) all.insert(all.end(), frame.begin(), frame.end());
    return all;
}

void expect_balanced(const Outbox& outbox) { EXPECT_EQ(unaccounted(outbox.counters()), outbox.waiting()); }

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

TEST(Outbox, gathers_as_many_frames_as_there_is_room_for) {
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

TEST(Outbox, drops_the_oldest_frame_when_full) {
    Outbox outbox = open_outbox(30, 20);    // room for two frames of 12
    for (std::uint8_t n = 1; n <= 3; ++n) push(outbox, numbered(n));
    EXPECT_EQ(gathered(outbox), joined({numbered(2), numbered(3)}));
    EXPECT_EQ(outbox.counters().queue_full, 1u);
    expect_balanced(outbox);
}

TEST(Outbox, a_partly_sent_frame_is_never_dropped) {
    Outbox outbox = open_outbox(30, 20);
    push(outbox, numbered(1));
    push(outbox, numbered(2));
    outbox.sent(1);
    push(outbox, numbered(3));
    push(outbox, numbered(4, 20));    // takes the whole room by itself
    const Bytes begun = numbered(1);
    EXPECT_EQ(gathered(outbox), joined({Bytes(begun.begin() + 1, begun.end()), numbered(4, 20)}));
    EXPECT_EQ(outbox.counters().queue_full, 2u);
    expect_balanced(outbox);
}

TEST(Outbox, datagrams_are_sent_or_fail_one_by_one) {
    Outbox outbox = open_outbox(1000, 100);
    for (std::uint8_t n = 1; n <= 3; ++n) push(outbox, numbered(n));
    outbox.sent_frame();
    outbox.drop_frame(&SendCounters::send_failed);
    EXPECT_EQ(gathered(outbox), numbered(3));
    EXPECT_EQ(outbox.counters().frames_out, 1u);
    EXPECT_EQ(outbox.counters().send_failed, 1u);
    expect_balanced(outbox);
}

TEST(Outbox, accepts_nothing_when_closed_and_is_emptied_by_closing) {
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

TEST(Outbox, images_may_be_longer_than_other_frames_if_those_have_the_default_limit) {
    Outbox outbox{{}};
    outbox.open();
    const auto frame_of = [](std::uint8_t id, std::size_t size) { return support::frame(1, 2, id, Bytes(size)); };
    const auto refusal = [&](const Bytes& frame) { return outbox.push(ano::FrameView{frame}, image, start); };
    EXPECT_EQ(refusal(frame_of(0xB0, 19'217)), nullptr);
    EXPECT_EQ(refusal(frame_of(0xB0, 20'001)), &SendCounters::too_big);
    EXPECT_EQ(refusal(frame_of(0xF1, 4097)), &SendCounters::too_big);
    EXPECT_EQ(gathered(outbox), frame_of(0xB0, 19'217));
    Outbox small{{.bytes = 10'000}};
    small.open();
    EXPECT_EQ(small.push(ano::FrameView{frame_of(0xB0, 19'217)}, image, start), &SendCounters::too_big) << "no room in the queue";
    Outbox vendor{{.max_data = 198}};
    vendor.open();
    EXPECT_EQ(vendor.push(ano::FrameView{frame_of(0xB0, 199)}, image, start), &SendCounters::too_big);
    expect_balanced(small);
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

Outbox of_uart() {
    Outbox outbox{{.bytes = 1000, .max_data = 100, .flush_bytes = 108}};
    outbox.open();
    return outbox;
}

TEST(Outbox, zero_bytes_are_sent_before_the_next_frame_and_do_not_count_as_a_frame) {
    Outbox outbox = of_uart();
    EXPECT_TRUE(outbox.flush_parser(start));
    EXPECT_FALSE(outbox.empty());
    EXPECT_EQ(outbox.waiting(), 0u);
    push(outbox, numbered(1), command);
    EXPECT_EQ(outbox.next(start).size, Outbox::zeros_at_once);
    EXPECT_TRUE(outbox.next(start).is_zeros) << "any number of them may leave";
    EXPECT_EQ(gathered(outbox), joined({Bytes(108), numbered(1)}));
    EXPECT_EQ(gathered(outbox, start, 100), Bytes(100)) << "they may leave in parts";
    outbox.sent(100);
    EXPECT_EQ(gathered(outbox, start, 30), joined({Bytes(8), numbered(1)}));
    outbox.sent(8 + 12);
    EXPECT_TRUE(outbox.empty());
    EXPECT_EQ(outbox.counters().flush_bytes, 108u);
    EXPECT_EQ(outbox.counters().bytes_out, 12u);
    EXPECT_EQ(outbox.counters().frames_out, 1u);
    expect_balanced(outbox);
}

// A slow line has sent some of them when a setpoint arrives, which does not wait for the rest.
TEST(Outbox, zero_bytes_stop_when_a_second_frame_waits) {
    Outbox outbox = of_uart();
    ASSERT_TRUE(outbox.flush_parser(start));
    push(outbox, numbered(1), command);
    ASSERT_EQ(gathered(outbox, start, 8), Bytes(8));
    outbox.sent(8);
    EXPECT_EQ(outbox.zeros(), 100u);
    push(outbox, numbered(2), command);
    EXPECT_EQ(outbox.zeros(), 0u);
    EXPECT_EQ(gathered(outbox), joined({numbered(1), numbered(2)}));
    outbox.sent(24);
    EXPECT_EQ(outbox.counters().flush_bytes, 8u);
    EXPECT_TRUE(outbox.empty());
    EXPECT_FALSE(outbox.flush_parser(start + 999ms)) << "once a second all the same";
    expect_balanced(outbox);
}

TEST(Outbox, waiting_frames_can_be_dropped_except_the_rest_of_a_partly_sent_one) {
    Outbox outbox = of_uart();
    for (std::uint8_t n = 1; n <= 3; ++n) push(outbox, numbered(n), n == 2 ? command : QueuePolicy{});
    ASSERT_EQ(gathered(outbox).size(), 36u);
    outbox.sent(5);
    outbox.drop_waiting(&SendCounters::denied_out);
    EXPECT_EQ(outbox.waiting(), 1u);
    EXPECT_EQ(outbox.counters().denied_out, 2u);
    EXPECT_EQ(gathered(outbox).size(), 7u);
    outbox.sent(7);
    EXPECT_TRUE(outbox.empty());
    ASSERT_TRUE(outbox.flush_parser(start));
    outbox.drop_waiting(&SendCounters::denied_out);
    EXPECT_TRUE(outbox.empty());
    push(outbox, numbered(4), command);
    EXPECT_EQ(gathered(outbox), numbered(4));
    expect_balanced(outbox);
}

TEST(Outbox, zero_bytes_are_sent_once_a_second_and_only_when_nothing_waits) {
    Outbox outbox = of_uart();
    push(outbox, numbered(1));
    EXPECT_FALSE(outbox.flush_parser(start));
    outbox.sent(12);
    EXPECT_TRUE(outbox.flush_parser(start));
    EXPECT_FALSE(outbox.flush_parser(start + 2s)) << "they wait";
    outbox.sent(108);
    EXPECT_FALSE(outbox.flush_parser(start + 999ms));
    EXPECT_EQ(outbox.until_flush(start + 600ms), 400ms);
    push(outbox, numbered(2));
    EXPECT_EQ(outbox.until_flush(start + 600ms), 0s) << "a frame waits, by which the device gets bytes";
    outbox.sent(12);
    EXPECT_EQ(outbox.until_flush(start + 1s), 0s);
    EXPECT_TRUE(outbox.flush_parser(start + 1s));
    outbox.close();
    EXPECT_TRUE(outbox.empty());
    EXPECT_FALSE(outbox.flush_parser(start + 3s)) << "it is closed";
    Outbox no_uart = open_outbox(1000, 100);
    EXPECT_FALSE(no_uart.flush_parser(start));
}

TEST(Outbox, reports_whether_a_frame_of_a_channel_waits) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), command, 3);
    EXPECT_TRUE(outbox.has_waiting(ChannelId{3}));
    EXPECT_FALSE(outbox.has_waiting(ourselves));
    push(outbox, numbered(2), command);
    EXPECT_TRUE(outbox.has_waiting(ourselves));
    gathered(outbox);
    outbox.sent(12 + 4);
    EXPECT_FALSE(outbox.has_waiting(ourselves)) << "it has begun to leave";
}

TEST(Outbox, urgent_frames_are_sent_before_telemetry_before_bulk) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), image);
    push(outbox, numbered(2), text);
    push(outbox, numbered(3), command);
    push(outbox, numbered(4), text);
    push(outbox, numbered(5), command);
    EXPECT_EQ(gathered(outbox), joined({numbered(3), numbered(5), numbered(2), numbered(4), numbered(1)}));
}

TEST(Outbox, urgent_frames_do_not_overtake_a_partly_sent_frame) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), image);
    outbox.sent(11);
    push(outbox, numbered(2), command);
    const Bytes begun = numbered(1);
    EXPECT_EQ(gathered(outbox), joined({Bytes{begun.back()}, numbered(2)}));
    EXPECT_EQ(outbox.next(start).size, 1u);
    EXPECT_TRUE(outbox.next(start).urgent) << "it waits for the rest";
    outbox.sent(1);
    EXPECT_EQ(outbox.next(start).size, 12u);
    EXPECT_TRUE(outbox.next(start).urgent);
    outbox.sent(12);
    EXPECT_EQ(outbox.next(start).size, 0u);
}

TEST(Outbox, the_rest_of_an_urgent_frame_is_urgent) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), command);
    push(outbox, numbered(2), image);
    outbox.sent(5);
    EXPECT_TRUE(outbox.next(start).urgent);
    outbox.sent(7);
    EXPECT_FALSE(outbox.next(start).urgent);
}

TEST(Outbox, a_dropped_request_needs_no_answer) {
    InFlight questions;
    Outbox outbox = open_outbox(1000, 100);
    outbox.set_in_flight(&questions);
    for (std::uint8_t n = 1; n <= 3; ++n) push(outbox, support::frame(0xFE, 0xDC, 0xE0, {2, n, 0}), command);
    EXPECT_EQ(questions.size(), 3u);
    outbox.drop_frame(&SendCounters::send_failed);
    EXPECT_EQ(questions.size(), 2u);
    outbox.sent_frame();
    EXPECT_EQ(questions.size(), 2u) << "it left, and is to be answered";
}

// Three times the sent amount is offered; nothing can be replaced.
TEST(Outbox, each_class_gets_at_least_a_tenth_of_the_bytes) {
    Outbox outbox = open_outbox(4000, 100);
    std::array<std::size_t, 3> bytes{};
    for (int i = 0; i < 20000; ++i) {
        push(outbox, numbered(0, 13), command);
        push(outbox, numbered(0, 13), command);
        push(outbox, numbered(1, 13), text);
        push(outbox, numbered(2, 60), image);
        std::array<Piece, 1> piece;
        ASSERT_EQ(outbox.gather(piece), 1u);
        bytes[piece[0][ano::header_size]] += piece[0].size();
        outbox.sent_frame();
        expect_balanced(outbox);
    }
    const auto all = static_cast<double>(bytes[0] + bytes[1] + bytes[2]);
    EXPECT_NEAR(static_cast<double>(bytes[0]) / all, 0.80, 0.01);
    EXPECT_NEAR(static_cast<double>(bytes[1]) / all, 0.10, 0.005);
    EXPECT_NEAR(static_cast<double>(bytes[2]) / all, 0.10, 0.005);
    EXPECT_GT(outbox.counters().queue_full, 20000u);
}

TEST(Outbox, a_class_with_nothing_waiting_saves_up_no_share) {
    Outbox outbox = open_outbox(4000, 100);
    for (int i = 0; i < 1000; ++i) {    // nothing else waits
        push(outbox, numbered(0), command);
        outbox.sent_frame();
    }
    push(outbox, numbered(1), text);
    push(outbox, numbered(0), command);
    EXPECT_EQ(gathered(outbox), joined({numbered(0), numbered(1)}));
}

TEST(Outbox, full_of_urgent_frames_drops_the_oldest_and_refuses_others) {
    Outbox outbox = open_outbox(36, 20);
    for (std::uint8_t n = 1; n <= 4; ++n) push(outbox, numbered(n), command);
    push(outbox, numbered(5), text);
    EXPECT_EQ(gathered(outbox), joined({numbered(2), numbered(3), numbered(4)}));
    EXPECT_EQ(outbox.counters().queue_full, 2u);
    expect_balanced(outbox);
}

TEST(Outbox, drops_the_oldest_frame_of_the_lowest_class_first) {
    Outbox outbox = open_outbox(48, 20);
    push(outbox, numbered(1), text);
    push(outbox, numbered(2), image);
    push(outbox, numbered(3), image);
    push(outbox, numbered(4), text);
    push(outbox, numbered(5), command);
    EXPECT_EQ(gathered(outbox), joined({numbered(5), numbered(1), numbered(4), numbered(3)}));
    push(outbox, numbered(6, 20), image);    // would fit only if other classes than bulk gave way
    EXPECT_EQ(gathered(outbox), joined({numbered(5), numbered(1), numbered(4), numbered(3)}));
    EXPECT_EQ(outbox.counters().queue_full, 2u);
    expect_balanced(outbox);
}

TEST(Outbox, newer_frames_replace_older_ones_only_while_congested) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), attitude);
    push(outbox, numbered(2), attitude);
    EXPECT_EQ(outbox.waiting(), 2u);
    outbox.set_congested();
    push(outbox, numbered(3), attitude);
    EXPECT_EQ(gathered(outbox), joined({numbered(1), numbered(3)}));
    EXPECT_EQ(outbox.counters().superseded, 1u);
    outbox.sent(outbox.waiting_bytes());
    EXPECT_FALSE(outbox.congested()) << "until nothing waits";
    outbox.set_congested();
    EXPECT_FALSE(outbox.congested()) << "no configuration is waiting";
    expect_balanced(outbox);
}

// As after a pause of a radio.
TEST(Outbox, of_setpoints_that_arrived_together_only_the_newest_waits_when_the_wire_accepts_no_more) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), stick, 1);
    std::array<Piece, 1> first;
    ASSERT_EQ(outbox.gather(first), 1u);
    outbox.sent(first[0].size() - 1);
    for (std::uint8_t n = 2; n <= 5; ++n) push(outbox, numbered(n), stick, n == 2 ? 7 : 1);
    push(outbox, numbered(6), attitude);
    push(outbox, numbered(7), attitude);
    push(outbox, numbered(8), command);
    push(outbox, numbered(9), command);
    outbox.set_congested();
    outbox.set_congested();
    EXPECT_EQ(outbox.counters().superseded, 2u) << "3 and 4 of one sender; 1 is partly sent, 2 is the only one of another";
    EXPECT_EQ(outbox.waiting(), 7u);
    push(outbox, numbered(10), stick, 1);
    EXPECT_EQ(outbox.counters().superseded, 3u);
    expect_balanced(outbox);
}

TEST(Outbox, only_frames_of_the_same_kind_are_replaced) {
    Outbox outbox = open_outbox(1000, 100);
    const auto one = [](std::uint8_t source, std::uint8_t destination, std::uint8_t id, Bytes data) {
        return support::frame(source, destination, id, data);
    };
    push(outbox, one(1, 2, 3, {0}), attitude);
    outbox.set_congested();
    push(outbox, one(9, 2, 3, {0}), attitude);
    push(outbox, one(1, 9, 3, {0}), attitude);
    push(outbox, one(1, 2, 9, {0}), attitude);
    push(outbox, one(1, 2, 0x34, {1, 0}), ranging);
    push(outbox, one(1, 2, 0x34, {2, 0}), ranging);
    push(outbox, one(1, 2, 0x34, {}), ranging);
    push(outbox, one(1, 2, 0x34, {}), ranging);
    push(outbox, one(1, 2, 0xA0, {0}), text);
    push(outbox, one(1, 2, 0xA0, {0}), text);
    EXPECT_EQ(outbox.waiting(), 10u);
    push(outbox, one(1, 2, 0x34, {2, 1}), ranging);
    EXPECT_EQ(outbox.waiting(), 10u);
    EXPECT_EQ(outbox.counters().superseded, 1u);
}

TEST(Outbox, the_only_waiting_frame_can_be_replaced) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), attitude);
    outbox.set_congested();
    for (std::uint8_t n = 2; n < 100; ++n) push(outbox, numbered(n), attitude);
    EXPECT_TRUE(outbox.congested());
    EXPECT_EQ(gathered(outbox), numbered(99));
    expect_balanced(outbox);
}

// Twenty kinds, the first ten times as often as the others, on a line with a quarter of their rate.
TEST(Outbox, no_kind_of_frame_starves_and_sent_frames_are_fresh) {
    Outbox outbox = open_outbox(32 * 1024, 100);
    std::array<int, 20> left{};
    int tick = 0;
    int oldest = 0;
    push(outbox, numbered(0), text);
    outbox.set_congested();
    const auto offer = [&](std::uint8_t kind) {
        const Bytes data{kind, static_cast<std::uint8_t>(tick), static_cast<std::uint8_t>(tick >> 8),
                         static_cast<std::uint8_t>(tick >> 16)};
        push(outbox, support::frame(0xDC, 0xFE, kind, data), attitude);
    };
    for (; tick < 40000; ++tick) {
        offer(0);
        if (tick % 10 == 0)
            for (std::uint8_t kind = 1; kind < 20; ++kind) offer(kind);
        if (tick % 4 > 2) continue;    // 0.75 frames are sent for 2.9 offered
        std::array<Piece, 1> piece;
        ASSERT_EQ(outbox.gather(piece), 1u);
        const auto data = piece[0].subspan(ano::header_size);
        ++left[data[0]];
        if (tick > 100) oldest = std::max(oldest, tick - (data[1] | data[2] << 8 | data[3] << 16));
        outbox.sent_frame();
    }
    const auto [least, most] = std::minmax_element(left.begin(), left.end());
    EXPECT_GT(*least, 30000 / 20 / 2) << "half of an equal share";
    EXPECT_LT(*most, 30000 / 20 * 3);
    EXPECT_LT(oldest, 40) << "twenty frames take 27 ticks";
    EXPECT_LE(outbox.waiting(), 40u) << "two of a kind at the most";
}

TEST(Outbox, ages_while_the_machine_sleeps) {
    Outbox outbox{{.bytes = 1000, .max_data = 100, .age = {.control = 200ms, .telemetry = 1s, .rest = 5s}}};
    outbox.open();
    push(outbox, numbered(1), command);
    push(outbox, numbered(3), attitude);
    outbox.push(ano::FrameView{numbered(4)});    // never stale
    outbox.grow_older(1s);
    EXPECT_EQ(gathered(outbox, start), joined({numbered(1), numbered(4)}));
    EXPECT_EQ(gathered(outbox, start + 4s), numbered(4));
    outbox.grow_older(1h);
    EXPECT_EQ(gathered(outbox, start + 4s), numbered(4));
    EXPECT_EQ(outbox.counters().stale, 2u);
    expect_balanced(outbox);
}

TEST(Outbox, reports_whether_a_received_frame_is_already_stale) {
    const Outbox outbox{{.bytes = 1000, .max_data = 100, .age = {.control = 200ms, .telemetry = 1s, .rest = 5s}}};
    EXPECT_FALSE(outbox.is_stale(policy_of(0x41), 200ms - 1ns));
    EXPECT_TRUE(outbox.is_stale(policy_of(0x41), 200ms));
    EXPECT_FALSE(outbox.is_stale(policy_of(0xC0), 5s - 1ns));
    EXPECT_TRUE(outbox.is_stale(policy_of(0xC0), 5s));
}

TEST(Outbox, frames_wait_no_longer_than_their_age_limit) {
    Outbox outbox{{.bytes = 1000, .max_data = 100, .age = {.control = 200ms, .telemetry = 1s, .rest = 5s}}};
    outbox.open();
    push(outbox, numbered(1), command);
    push(outbox, numbered(2), stick);
    push(outbox, numbered(3), attitude);
    push(outbox, numbered(4), image);
    EXPECT_EQ(gathered(outbox, start + 200ms - 1ns), joined({numbered(2), numbered(1), numbered(3), numbered(4)}));
    EXPECT_EQ(gathered(outbox, start + 200ms), joined({numbered(1), numbered(3), numbered(4)}));
    EXPECT_EQ(gathered(outbox, start + 1s), joined({numbered(1), numbered(4)}));
    outbox.sent(1);
    EXPECT_EQ(gathered(outbox, start + 5s).size(), 11u) << "what has begun to leave goes on";
    EXPECT_EQ(outbox.counters().stale, 3u);
    expect_balanced(outbox);
    outbox.set_age_limits({.control = 1ms, .telemetry = 1ms, .rest = 1ms});
    push(outbox, numbered(5), command);
    outbox.sent(11);
    EXPECT_EQ(outbox.next(start + 1ms).size, 0u);
    EXPECT_TRUE(outbox.empty());
    expect_balanced(outbox);
}

TEST(Outbox, channels_take_turns_and_then_the_senders_of_a_channel) {
    Outbox outbox = open_outbox(1000, 100);
    for (std::uint8_t n = 0; n < 3; ++n) push(outbox, from(1, n), command, 5);
    for (std::uint8_t n = 0; n < 2; ++n) push(outbox, from(2, n), command, 5);
    for (std::uint8_t n = 0; n < 4; ++n) push(outbox, from(1, 10 + n), command, 6);    // another sender with that address
    Bytes all;
    while (!outbox.empty()) {
        std::array<Piece, 1> piece;
        ASSERT_EQ(outbox.gather(piece), 1u);
        all.insert(all.end(), piece[0].begin(), piece[0].end());
        outbox.sent_frame();
        expect_balanced(outbox);
    }
    std::string turns;
    for (const Bytes& frame : support::split(all).frames) turns += frame[6] >= 10 ? 'c' : frame[1] == 1 ? 'a' : 'b';
    EXPECT_EQ(turns, "cacbcacba");
}

TEST(Outbox, a_sender_without_waiting_frames_is_served_before_those_with_waiting_ones) {
    Outbox outbox = open_outbox(4000, 100);
    for (std::uint8_t channel = 1; channel < 20; ++channel)
        for (std::uint8_t n = 0; n < 5; ++n) push(outbox, from(1, n), command, channel);
    push(outbox, from(3, 42), command, 40);
    EXPECT_EQ(gathered(outbox, start, 12), from(3, 42));
    outbox.sent_frame();
    push(outbox, from(3, 43), command, 40);
    EXPECT_NE(gathered(outbox, start, 12), from(3, 43)) << "not each time, or the others would wait for ever";
}

TEST(Outbox, only_stick_frames_overtake_others_of_a_sender_and_never_two_in_a_row) {
    Outbox outbox = open_outbox(1000, 100);
    const auto one = [](std::uint8_t id, std::uint8_t n) { return support::frame(0xFE, 0xDC, id, {n}); };
    const auto push_frame = [&](std::uint8_t id, std::uint8_t n) { push(outbox, one(id, n), policy_of(id), 1); };
    push_frame(0xE1, 1);
    push_frame(0xC0, 2);
    push_frame(0x40, 3);
    push_frame(0x41, 4);
    push_frame(0xE1, 5);
    EXPECT_EQ(gathered(outbox), joined({one(0x40, 3), one(0xE1, 1), one(0x41, 4), one(0xC0, 2), one(0xE1, 5)}));
}

TEST(Outbox, stick_frames_overtake_again_after_another_frame_was_sent) {
    Outbox outbox = open_outbox(1000, 100);
    const auto one = [](std::uint8_t id, std::uint8_t n) { return support::frame(0xFE, 0xDC, id, {n}); };
    const auto push_frame = [&](std::uint8_t id, std::uint8_t n) { push(outbox, one(id, n), policy_of(id), 1); };
    push_frame(0xE1, 1);
    push_frame(0xE1, 2);
    push_frame(0x40, 3);
    outbox.sent_frame();    // the sticks
    outbox.sent_frame();
    push_frame(0x40, 4);
    EXPECT_EQ(gathered(outbox), joined({one(0x40, 4), one(0xE1, 2)}));
}

TEST(Outbox, frames_of_another_channel_are_not_replaced) {
    Outbox outbox = open_outbox(1000, 100);
    push(outbox, numbered(1), attitude, 1);
    outbox.set_congested();
    push(outbox, numbered(2), attitude, 2);    // the same address: forged, or another host
    EXPECT_EQ(outbox.waiting(), 2u);
    push(outbox, numbered(3), attitude, 1);
    EXPECT_EQ(gathered(outbox), joined({numbered(2), numbered(3)}));
    EXPECT_EQ(outbox.counters().superseded, 1u);
}

TEST(Outbox, drops_the_oldest_frame_of_the_sender_with_the_most_waiting) {
    Outbox outbox = open_outbox(100, 20);    // room for eight frames of 12
    push(outbox, from(1, 1), command, 1);
    for (std::uint8_t n = 0; n < 20; ++n) push(outbox, from(2, n), command, 2);
    for (std::uint8_t address = 10; address < 250; ++address) push(outbox, from(address, address), command, 3);
    const auto left = support::split(gathered(outbox)).frames;
    EXPECT_EQ(left.size(), 8u);
    EXPECT_TRUE(std::find(left.begin(), left.end(), from(1, 1)) != left.end()) << "the first, and the only one of its sender";
    EXPECT_GE(std::count_if(left.begin(), left.end(), [](const Bytes& f) { return f[1] == 2; }), 3) << "of seven";
    EXPECT_TRUE(std::find(left.begin(), left.end(), from(2, 19)) != left.end());
    EXPECT_TRUE(std::find(left.begin(), left.end(), from(2, 0)) == left.end());
    expect_balanced(outbox);
}

// A queue of 400 bytes: 40 are reserved for each class, or one frame of up to 100.
TEST(Outbox, no_class_is_displaced_from_the_queue_by_another) {
    for (const QueuePolicy flood : {command, text, image})
        for (const QueuePolicy few : {command, text, image}) {
            if (flood == few) continue;
            SCOPED_TRACE(testing::Message() << static_cast<int>(flood.traffic) << " and " << static_cast<int>(few.traffic));
            Outbox outbox = open_outbox(400, 300);
            for (std::uint8_t n = 0; n < 100; ++n) push(outbox, numbered(n), flood, 1);
            push(outbox, numbered(100, 92), few, 2);
            for (std::uint8_t n = 0; n < 100; ++n) push(outbox, numbered(n), flood, 1);
            const auto has = [&](const Bytes& frame) {
                const auto left = support::split(gathered(outbox)).frames;
                return std::find(left.begin(), left.end(), frame) != left.end();
            };
            EXPECT_TRUE(has(numbered(100, 92)));
            EXPECT_TRUE(has(numbered(99)));
            expect_balanced(outbox);
        }
}

TEST(Outbox, gathers_within_a_budget) {
    Outbox outbox = open_outbox(1000, 100);
    for (std::uint8_t n = 1; n <= 4; ++n) push(outbox, numbered(n));
    EXPECT_EQ(gathered(outbox, start, 36).size(), 36u);
    EXPECT_EQ(gathered(outbox, start, 35).size(), 24u);
    EXPECT_EQ(gathered(outbox, start, 11).size(), 0u);
    outbox.sent(4);
    EXPECT_EQ(gathered(outbox, start, 20).size(), 20u) << "the rest of one that has begun, and one more";
}

TEST(Outbox, refused_frames_are_accounted_for) {
    Outbox outbox = open_outbox(1000, 100);
    outbox.refuse(&SendCounters::limited);
    outbox.refuse(&SendCounters::denied_out);
    EXPECT_EQ(outbox.counters().offered, 2u);
    expect_balanced(outbox);
}

}    // namespace
}    // namespace outbox_tests
