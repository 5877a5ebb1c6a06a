#include <link/tcp/in_flight_limit.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <deque>

using anogate::InFlightLimit;
using namespace std::chrono_literals;

namespace in_flight_limit_tests {
namespace {

// A connection whose packets pass one slow line, one behind the other; its sender always has more.
class Line {
public:
    Line(double bytes_per_second, ano::Duration way) : rate_{bytes_per_second}, way_{way} {}

    void change_rate(double bytes_per_second) { rate_ = bytes_per_second; }

    void run(ano::Duration time) {
        longest_wait_ = {};
        arrived_ = 0;
        for (const auto end = now_ + time; now_ < end; now_ += 500us) {
            acknowledge();
            while (limit_.wait(in_flight_, now_, [this] { return trip_; }) == ano::Duration::zero()) send(1000);
        }
    }

    /// Of a packet in the last run(): behind others, before the line.
    ano::Duration longest_wait() const { return longest_wait_; }
    double bytes() const { return static_cast<double>(arrived_); }
    std::size_t in_flight() const { return in_flight_; }
    std::size_t limit() const { return limit_.limit(); }

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
        for (; !packets_.empty() && packets_.front().acknowledged <= now_; packets_.pop_front()) {
            const Packet& first = packets_.front();
            const auto took = first.acknowledged - first.sent;
            trip_.shortest = trip_.shortest == ano::Duration::zero() ? took : std::min(trip_.shortest, took);
            trip_.now = trip_.now == ano::Duration::zero() ? took : trip_.now + (took - trip_.now) / 8;
            in_flight_ -= first.size;
            arrived_ += first.size;
        }
    }

    double rate_;
    ano::Duration way_;
    InFlightLimit limit_;
    std::deque<Packet> packets_;
    InFlightLimit::RoundTrip trip_;
    std::size_t in_flight_ = 0, arrived_ = 0;
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

TEST(InFlightLimit, follows_a_line_that_becomes_slower_and_faster) {
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

TEST(InFlightLimit, lets_the_line_run_empty_once_a_minute) {
    Line line{2 * mbit, 2ms};
    std::size_t seen = 0;
    for (int i = 0; i < 130'000; ++i) {
        line.run(1ms);
        if (i > 1'000 && line.in_flight() <= InFlightLimit::nearly_none + 1000) seen += seen % 2 == 0 ? 1 : 0;
        else if (i > 1'000 && line.in_flight() > 6000) seen += seen % 2;
    }
    EXPECT_EQ(seen, 4u);    // twice empty, and full again
}

TEST(InFlightLimit, does_not_ask_for_the_round_trip_while_little_is_on_the_way) {
    InFlightLimit limit;
    EXPECT_EQ(limit.wait(InFlightLimit::least, ano::TimePoint{30s}, []() -> InFlightLimit::RoundTrip { throw 1; }), 0s);
}

TEST(InFlightLimit, asks_again_soon_while_nothing_is_acknowledged) {
    InFlightLimit limit;
    const auto wait = limit.wait(20'000, ano::TimePoint{30s}, [] { return InFlightLimit::RoundTrip{5s, 3ms}; });
    EXPECT_GE(wait, 1ms);
    EXPECT_LE(wait, 100ms);
}

}    // namespace
}    // namespace in_flight_limit_tests
