// Time-outs, the number of requests in flight, and the answers that end a request.
#include <ano/typed.hpp>
#include <host/exchange.hpp>
#include <host/window.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace ano::host::exchange_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using support::operator+;

TEST(RoundTrip, starts_with_a_time_out_of_200_ms_before_the_first_answer) {
    RoundTrip trip;
    EXPECT_EQ(trip.time_out(), 200ms);
    EXPECT_FALSE(trip.smoothed());
}

TEST(RoundTrip, follows_the_measurements_according_to_rfc_6298) {
    RoundTrip trip;
    trip.answered(100ms, false);
    EXPECT_EQ(trip.smoothed(), 100ms);
    EXPECT_EQ(trip.time_out(), 300ms);    // 100 + 4 * 50
    trip.answered(180ms, false);
    EXPECT_EQ(trip.smoothed(), 110ms);            // 100 + 80/8
    EXPECT_EQ(trip.time_out(), 110ms + 230ms);    // variation 50 + (80 - 50)/4
}

TEST(RoundTrip, limits_the_time_out_to_30_ms_to_2_s) {
    RoundTrip fast;
    for (int i = 0; i < 100; ++i) fast.answered(1ms, false);
    EXPECT_EQ(fast.time_out(), 30ms);
    RoundTrip slow;
    slow.answered(5s, false);
    EXPECT_EQ(slow.time_out(), 2s);
}

TEST(RoundTrip, keeps_a_margin_for_adapters_that_collect_bytes_when_all_round_trips_are_equal) {
    RoundTrip trip;
    for (int i = 0; i < 100; ++i) trip.answered(200ms, false);
    EXPECT_EQ(trip.time_out(), 220ms);
}

TEST(RoundTrip, doubles_the_time_out_with_each_loss_up_to_2_s_before_the_first_answer) {
    RoundTrip trip;
    EXPECT_EQ(trip.time_out_after(0, false), 200ms);
    EXPECT_EQ(trip.time_out_after(1, false), 400ms);
    EXPECT_EQ(trip.time_out_after(2, true), 800ms);
    EXPECT_EQ(trip.time_out_after(3, false), 1600ms);
    EXPECT_EQ(trip.time_out_after(60, false), 2s);
}

// After a list that filled the line, a single answer takes less time than those of the list.
TEST(RoundTrip, uses_the_shortest_round_trip_for_a_single_request) {
    RoundTrip trip;
    trip.answered(20ms, false);
    for (int i = 0; i < 50; ++i) trip.answered(600ms, false);
    EXPECT_GE(trip.time_out_after(0, false), 600ms);
    EXPECT_EQ(trip.time_out_after(0, false, true), 280ms);
    RoundTrip slow;
    for (int i = 0; i < 50; ++i) slow.answered(200ms, false);
    EXPECT_EQ(slow.time_out_after(0, false, true), slow.time_out());
}

TEST(RoundTrip, does_not_double_the_time_out_after_random_losses) {
    RoundTrip trip;
    for (int i = 0; i < 20; ++i) trip.answered(2ms, false);
    EXPECT_FALSE(trip.grows());
    for (unsigned losses = 0; losses < 5; ++losses) EXPECT_EQ(trip.time_out_after(losses, true), 30ms);
    EXPECT_EQ(trip.time_out_after(5, true), 120ms) << "this one has other reasons";
}

TEST(RoundTrip, multiplies_the_interval_by_at_most_four_for_a_device_that_does_not_answer) {
    RoundTrip trip;
    for (int i = 0; i < 20; ++i) trip.answered(2ms, false);
    EXPECT_EQ(trip.time_out_after(1, false), 60ms);
    EXPECT_EQ(trip.time_out_after(2, false), 120ms);
    EXPECT_EQ(trip.time_out_after(9, false), 120ms);
}

TEST(RoundTrip, doubles_the_time_out_while_round_trips_grow) {
    RoundTrip trip;
    trip.answered(10ms, false);
    for (int i = 0; i < 100; ++i) trip.answered(100ms, false);
    EXPECT_TRUE(trip.grows());
    EXPECT_EQ(trip.time_out_after(1, true), 2 * trip.time_out());
    EXPECT_EQ(trip.time_out_after(9, true), 2s);
}

TEST(RoundTrip, counts_a_repeated_exchange_only_if_all_are_repeated_and_an_answer_arrived_twice) {
    RoundTrip trip;
    for (int i = 0; i < 9; ++i) trip.answered(1200ms, true);
    EXPECT_FALSE(trip.smoothed()) << "frames are lost";
    trip.doubled();
    trip.answered(1200ms, true);
    EXPECT_EQ(trip.smoothed(), 1200ms);
    trip.doubled();
    trip.answered(100ms, true);
    trip.answered(1200ms, false);
    trip.answered(100ms, true);
    trip.answered(100ms, true);
    EXPECT_EQ(trip.smoothed(), 1200ms);
}

TEST(Window, opens_by_one_for_each_answer_up_to_eight) {
    Window window;
    EXPECT_EQ(window.size(), 1u);
    for (std::size_t n = 2; n <= 8; ++n) {
        window.answered(false);
        EXPECT_EQ(window.size(), n);
    }
    window.answered(false);
    EXPECT_EQ(window.size(), 8u);
}

TEST(Window, halves_only_when_more_than_half_of_the_last_16_were_lost_and_round_trips_grow) {
    Window window;
    for (int i = 0; i < 16; ++i) window.answered(false);
    for (int i = 0; i < 8; ++i) {
        window.lost(false, true);
        EXPECT_EQ(window.size(), 8u);
    }
    window.lost(false, true);
    EXPECT_EQ(window.size(), 4u);
    for (int i = 0; i < 8; ++i) window.lost(false, true);
    EXPECT_EQ(window.size(), 4u) << "what was lost before the halving does not count again";
    window.lost(false, true);
    EXPECT_EQ(window.size(), 2u);
    for (int i = 0; i < 90; ++i) window.lost(false, true);
    EXPECT_EQ(window.size(), 1u);
}

TEST(Window, stays_open_where_one_in_five_is_lost) {
    Window window;
    for (int i = 0; i < 500; ++i) i % 5 == 0 ? window.lost(false, true) : window.answered(false);
    EXPECT_EQ(window.size(), 8u);
}

TEST(Window, shrinks_to_one_when_most_requests_are_lost_though_round_trips_do_not_grow) {
    Window window;
    for (int i = 0; i < 16; ++i) window.answered(false);
    for (int i = 0; i < 9; ++i) window.lost(false, false);
    EXPECT_EQ(window.size(), 1u);
    for (int i = 0; i < 9; ++i) window.lost(false, false);
    EXPECT_EQ(window.size(), 1u) << "those were sent before";
    for (int i = 1; i < 30; ++i) i % 10 == 0 ? window.lost(true, false) : window.answered(true);
    EXPECT_EQ(window.size(), 1u);
}

// At first a burst of interference looks the same.
TEST(Window, opens_again_when_two_requests_at_a_time_are_answered) {
    Window window;
    for (int i = 0; i < 16; ++i) window.answered(false);
    for (int i = 0; i < 9; ++i) window.lost(false, false);
    for (unsigned i = 0; i < Window::first_check; ++i) {
        EXPECT_EQ(window.size(), 1u);
        window.answered(true);
    }
    EXPECT_EQ(window.size(), 2u);
    for (int i = 0; i < 2; ++i) window.lost(false, false);
    for (unsigned i = 0; i < Window::check_factor * Window::first_check; ++i) {
        EXPECT_EQ(window.size(), 1u) << "the device does lose them";
        window.answered(true);
    }
    EXPECT_EQ(window.size(), 2u) << "less often, it is checked again";
    for (unsigned i = 0; i < Window::checked; ++i) i < 1 ? window.lost(false, false) : window.answered(false);
    EXPECT_EQ(window.size(), 2u);
    window.answered(false);
    EXPECT_EQ(window.size(), 3u);
}

TEST(Window, opens_again_when_answers_that_were_counted_as_lost_arrive_late) {
    Window window;
    for (int i = 0; i < 16; ++i) window.answered(false);
    for (int i = 0; i < 9; ++i) window.lost(false, false);
    ASSERT_EQ(window.size(), 1u);
    window.on_late_answer();
    EXPECT_EQ(window.size(), 1u);
    window.on_late_answer();
    EXPECT_EQ(window.size(), 2u);
    for (int i = 0; i < 9; ++i) {
        window.lost(false, false);
        window.on_late_answer();
    }
    EXPECT_EQ(window.size(), 2u) << "none of them was lost";
}

TEST(Window, opens_again_when_single_requests_are_lost_too) {
    Window window;
    for (int i = 0; i < 16; ++i) window.answered(false);
    const auto lose_most = [&] {
        for (int i = 0; i < 9; ++i) window.lost(false, false);
    };
    lose_most();
    ASSERT_EQ(window.size(), 1u);
    window.answered(true);
    window.lost(true, false);
    EXPECT_EQ(window.size(), 8u) << "one of the first eight is enough";
    lose_most();
    EXPECT_EQ(window.size(), 8u) << "not tried again soon";
    for (unsigned i = 0; i < Window::between_trials; ++i) window.answered(false);
    lose_most();
    ASSERT_EQ(window.size(), 1u);
    for (int i = 0; i < 20; ++i) window.answered(true);
    for (int i = 0; i < 2; ++i) window.lost(true, false);
    EXPECT_EQ(window.size(), 1u);
    window.lost(true, false);
    EXPECT_EQ(window.size(), 8u);
}

struct Asked {
    Bytes bytes;
    std::optional<Expectation> expects;
    explicit Asked(std::uint8_t id, const Bytes& data, std::uint8_t to = 0xDC)
        : bytes{support::frame(0xFE, to, id, data)}, expects{Expectation::of(FrameView{bytes})} {}
    bool met_by(std::uint8_t from, std::uint8_t to, std::uint8_t id, const Bytes& data) const {
        const Bytes frame = support::frame(from, to, id, data);
        return expects && expects->is_met_by(FrameView{frame});
    }
};

TEST(Expectation, accepts_only_the_matching_check_bytes_for_writes_commands_and_actions) {
    for (const auto& [id, data] : {std::pair{0xE1, Bytes{5, 0, 7}}, std::pair{0xC0, Bytes{1, 2, 3}},
                                   std::pair{0xE0, Bytes{0x10, 0xAB, 0}}, std::pair{0x61, Bytes(22)}}) {
        const Asked asked{static_cast<std::uint8_t>(id), data};
        ASSERT_TRUE(asked.expects) << id;
        EXPECT_TRUE(asked.expects->is_alone());
        const Checks checks = FrameView{asked.bytes}.checks();
        const auto id8 = static_cast<std::uint8_t>(id);
        EXPECT_TRUE(asked.met_by(0xDC, 0xFE, 0x00, {id8, checks.sum, checks.add}));
        EXPECT_FALSE(asked.met_by(0xDC, 0xFE, 0x00, {id8, checks.sum, static_cast<std::uint8_t>(checks.add + 1)}));
        EXPECT_FALSE(asked.met_by(0xDC, 0xFE, 0x00, {id8, static_cast<std::uint8_t>(checks.sum + 1), checks.add}));
        EXPECT_FALSE(asked.met_by(0xDC, 0xFE, 0x00, {0x40, checks.sum, checks.add}));
        EXPECT_FALSE(asked.met_by(0xDC, 0xFE, 0x00, {id8, checks.sum})) << "too short";
        EXPECT_FALSE(asked.met_by(0xDD, 0xFE, 0x00, {id8, checks.sum, checks.add})) << "another device";
        EXPECT_FALSE(asked.met_by(0xDC, 0xFD, 0x00, {id8, checks.sum, checks.add})) << "for somebody else";
    }
}

TEST(Expectation, accepts_only_the_matching_answer_to_a_request) {
    EXPECT_TRUE(Asked(0xE0, {0, 0, 0}).met_by(0xDC, 0xFE, 0xE3, {0xDC, 1, 0, 1, 0, 1, 0, 1, 0, 'x'}));
    EXPECT_TRUE(Asked(0xE0, {1, 0, 0}).met_by(0xDC, 0xFE, 0xE0, {1, 44, 1}));
    EXPECT_FALSE(Asked(0xE0, {1, 0, 0}).met_by(0xDC, 0xFE, 0xE0, {2, 44, 1}));
    EXPECT_TRUE(Asked(0xE0, {2, 5, 1}).met_by(0xDC, 0xFE, 0xE1, {5, 1, 0}));
    EXPECT_FALSE(Asked(0xE0, {2, 5, 1}).met_by(0xDC, 0xFE, 0xE1, {5, 0, 0}));
    EXPECT_FALSE(Asked(0xE0, {2, 5, 1}).met_by(0xDC, 0xFE, 0xE2, Bytes{5, 1, 0} + Bytes(20, 'x')));
    EXPECT_TRUE(Asked(0xE0, {3, 5, 1}).met_by(0xDC, 0xFE, 0xE2, Bytes{5, 1, 0} + Bytes(20, 'x')));
    EXPECT_FALSE(Asked(0xE0, {3, 5, 1}).met_by(0xDC, 0xFE, 0xE2, {5, 1, 0, 'x'})) << "shorter than its layout";
    EXPECT_TRUE(Asked(0xC1, {0, 0, 0}).met_by(0xDC, 0xFE, 0xC1, {0, 4, 0, 0, 0})) << "of an older device";
    EXPECT_TRUE(Asked(0xC1, {1, 3, 0}).met_by(0xDC, 0xFE, 0xC2, Bytes{3, 0} + Bytes(31, 'x')));
    EXPECT_TRUE(Asked(0x60, {0xFF}).met_by(0xDC, 0xFE, 0x60, {7}));
    EXPECT_TRUE(Asked(0x60, {4}).met_by(0xDC, 0xFE, 0x61, Bytes{4} + Bytes(21)));
    EXPECT_FALSE(Asked(0x60, {4}).met_by(0xDC, 0xFE, 0x61, Bytes{5} + Bytes(21)));
    EXPECT_FALSE(Asked(0xE0, {2, 5, 1}).expects->is_alone());
}

TEST(Expectation, accepts_a_description_of_an_old_device) {
    const Bytes old = Bytes{5, 1, 0xF6, 0xFF, 0xFF, 0xFF, 100, 0, 0, 0} + Bytes{'N'} + Bytes(19) + Bytes{'i'};
    EXPECT_TRUE(Asked(0xE0, {3, 5, 1}).met_by(0xDC, 0xFE, 0xE2, old));
}

TEST(Expectation, accepts_an_answer_of_any_device_to_a_request_for_a_port_id) {
    EXPECT_TRUE(Asked(0xE0, {1, 0, 0}, 3).met_by(0xDC, 0xFE, 0xE0, {1, 44, 1}));
    EXPECT_FALSE(Asked(0xE0, {1, 0, 0}, 3).met_by(0xFE, 0xFE, 0xE0, {1, 44, 1})) << "a host";
}

TEST(Expectation, accepts_different_answers_for_each_step_of_an_upgrade) {
    const Bytes info = Bytes{1} + Bytes(19);
    EXPECT_TRUE(Asked(0xF0, info).met_by(0xDC, 0xFE, 0xF0, {0, 0x02, 0x01}));
    EXPECT_TRUE(Asked(0xF0, info).met_by(0xDC, 0xFE, 0xF0, {0, 0x01, 0x01}));
    EXPECT_FALSE(Asked(0xF0, info).met_by(0xDC, 0xFE, 0xF0, {0, 0x12, 0x01}));
    EXPECT_TRUE(Asked(0xF0, {0, 0x10, 0x01}).met_by(0xDC, 0xFE, 0xF0, {0, 0x12, 0x01}));
    EXPECT_TRUE(Asked(0xF0, {0x10, 9, 0, 1, 2, 3}).met_by(0xDC, 0xFE, 0xF0, {0, 0x02, 0x10, 9, 0}));
    EXPECT_FALSE(Asked(0xF0, {0x10, 9, 0, 1, 2, 3}).met_by(0xDC, 0xFE, 0xF0, {0, 0x02, 0x10, 8, 0}));
    EXPECT_TRUE(Asked(0xF0, {0, 0x10, 0x10}).met_by(0xDC, 0xFE, 0xF0, {0, 0x11, 0x10}));
    EXPECT_TRUE(Asked(0xF0, {0, 0x10, 0x10}).expects->is_alone());
}

TEST(Expectation, does_not_exist_for_frames_without_an_answer) {
    EXPECT_FALSE(Asked(0x40, Bytes(20)).expects);
    EXPECT_FALSE(Asked(0xE0, {9, 0, 0}).expects);
    EXPECT_FALSE(Asked(0xF1, Bytes(8)).expects);
}

}    // namespace
}    // namespace ano::host::exchange_tests
