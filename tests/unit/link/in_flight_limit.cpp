#include <link/tcp/in_flight_limit.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <deque>

using anogate::InFlightLimit;
using namespace std::chrono_literals;

namespace in_flight_limit_tests {
namespace {

// A connection whose packets pass one slow line, one after the other; its sender always has more.
class Line {
public:
    /// `tick`: the delay of a packet's acknowledgement if no other packet follows it.
    Line(double bytes_per_second, ano::Duration way, ano::Duration tick = {}) : rate_{bytes_per_second}, way_{way}, tick_{tick} {}

    void change_rate(double bytes_per_second) { rate_ = bytes_per_second; }
    void change_way(ano::Duration way) { way_ = way; }

    void run(ano::Duration time) {
        longest_wait_ = {};
        arrived_ = 0;
        least_in_flight_ = SIZE_MAX;
        for (const auto end = now_ + time; now_ < end; now_ += 500us) {
            acknowledge();
            while (limit_.wait(in_flight_, now_, [this] { return trip_; }) == ano::Duration::zero()) send(1000);
        }
    }

    /// Of a packet in the last run(): behind others, before the line.
    ano::Duration longest_wait() const { return longest_wait_; }
    double bytes() const { return static_cast<double>(arrived_); }
    /// In the last run(), after its first sends.
    std::size_t least_in_flight() const { return least_in_flight_; }

private:
    struct Packet {
        std::size_t size;
        ano::TimePoint sent, acknowledged;
    };

    void send(std::size_t size) {
        const auto begins = std::max(now_, free_at_);
        longest_wait_ = std::max(longest_wait_, begins - now_);
        free_at_ = begins +
                   std::chrono::duration_cast<ano::Duration>(std::chrono::duration<double>(static_cast<double>(size) / rate_));
        packets_.push_back({size, now_, free_at_ + way_});
        in_flight_ += size;
    }
    void acknowledge() {
        while (!packets_.empty() && packets_.front().acknowledged + (packets_.size() == 1 ? tick_ : ano::Duration{}) <= now_) {
            const Packet first = packets_.front();
            const auto took = (packets_.size() == 1 ? now_ : first.acknowledged) - first.sent;
            packets_.pop_front();
            trip_.shortest = trip_.shortest == ano::Duration::zero() ? took : std::min(trip_.shortest, took);
            trip_.now = trip_.now == ano::Duration::zero() ? took : trip_.now + (took - trip_.now) / 8;
            in_flight_ -= first.size;
            least_in_flight_ = std::min(least_in_flight_, in_flight_);
            arrived_ += first.size;
        }
    }

    double rate_;
    ano::Duration way_, tick_;
    InFlightLimit limit_;
    std::deque<Packet> packets_;
    InFlightLimit::RoundTrip trip_;
    std::size_t in_flight_ = 0, arrived_ = 0, least_in_flight_ = 0;
    ano::TimePoint now_{1h}, free_at_{};
    ano::Duration longest_wait_{};
};

constexpr double mbit = 125'000;

TEST(InFlightLimit, keeps_the_queue_of_a_slow_line_short_from_the_first_second) {
    Line line{2 * mbit, 2ms};
    line.run(2s);
    EXPECT_LE(line.longest_wait(), 50ms);
    EXPECT_GE(line.bytes(), 0.95 * 2 * 2 * mbit);
    line.run(30s);
    EXPECT_LE(line.longest_wait(), 45ms);
    EXPECT_GE(line.bytes(), 0.98 * 30 * 2 * mbit);
}

TEST(InFlightLimit, keeps_long_lines_busy) {
    Line far{2 * mbit, 200ms};
    far.run(5s);
    far.run(20s);
    EXPECT_LE(far.longest_wait(), 250ms);
    EXPECT_GE(far.bytes(), 0.95 * 20 * 2 * mbit);
    Line fast{16 * mbit, 20ms};
    fast.run(2s);
    fast.run(20s);
    EXPECT_LE(fast.longest_wait(), 45ms);
    EXPECT_GE(fast.bytes(), 0.95 * 20 * 16 * mbit);
}

TEST(InFlightLimit, adapts_to_a_line_that_becomes_slower_and_faster) {
    Line line{20 * mbit, 2ms};
    line.run(5s);
    line.change_rate(2 * mbit);
    line.run(2s);
    line.run(5s);
    EXPECT_LE(line.longest_wait(), 45ms);
    line.change_rate(20 * mbit);
    line.run(2s);
    line.run(5s);
    EXPECT_GE(line.bytes(), 0.95 * 5 * 20 * mbit);
}

TEST(InFlightLimit, adapts_to_a_longer_path_although_the_kernel_remembers_the_shorter_one) {
    Line line{8 * mbit, 5ms};
    line.run(5s);
    line.change_way(400ms);
    line.run(30s);
    line.run(20s);
    EXPECT_GE(line.bytes(), 0.8 * 20 * std::min(8 * mbit, InFlightLimit::most / 0.4));
    line.change_way(5ms);
    line.run(2min);
    line.run(20s);
    EXPECT_LE(line.longest_wait(), 60ms);
}

TEST(InFlightLimit, keeps_a_slow_line_busy) {
    Line line{0.1 * mbit, 5ms};
    line.run(5s);
    line.run(2min);
    EXPECT_GE(line.bytes(), 0.95 * 120 * 0.1 * mbit);
}

TEST(InFlightLimit, drains_nearly_everything_in_flight_once_a_minute) {
    Line line{4 * mbit, 2ms};
    line.run(5s);
    EXPECT_GT(line.least_in_flight(), InFlightLimit::nearly_none);
    line.run(50s);
    EXPECT_GT(line.least_in_flight(), InFlightLimit::nearly_none);
    line.run(60s);
    EXPECT_LE(line.least_in_flight(), InFlightLimit::nearly_none);
}

TEST(InFlightLimit, never_delays_a_low_rate_stream) {
    InFlightLimit limit;
    ano::TimePoint now{1h};
    for (int i = 0; i < 100'000; ++i, now += 20ms)
        ASSERT_EQ(limit.wait(i % 3 == 0 ? 400 : 800, now, [] { return InFlightLimit::RoundTrip{200ms, 200ms}; }), 0s) << i;
}

// Some systems delay the acknowledgement of the last bytes; the path is not longer for that.
TEST(InFlightLimit, does_not_queue_more_because_of_late_acknowledgements) {
    Line line{2 * mbit, 2ms, 250ms};
    line.run(5s);
    line.run(3min);
    EXPECT_LE(line.longest_wait(), 45ms);
}

TEST(InFlightLimit, does_not_request_the_round_trip_while_little_is_in_flight) {
    InFlightLimit limit;
    const auto thrown = []() -> InFlightLimit::RoundTrip { throw 1; };
    EXPECT_EQ(limit.wait(0, ano::TimePoint{30s}, thrown), 0s);
    EXPECT_EQ(limit.wait(InFlightLimit::least, ano::TimePoint{31s}, thrown), 0s);
}

TEST(InFlightLimit, checks_again_soon_while_nothing_is_acknowledged) {
    InFlightLimit limit;
    const auto wait = limit.wait(20'000, ano::TimePoint{30s}, [] { return InFlightLimit::RoundTrip{5s, 3ms}; });
    EXPECT_GE(wait, 1ms);
    EXPECT_LE(wait, 100ms);
}

}    // namespace
}    // namespace in_flight_limit_tests
