// A slow line in simulated time: setpoints in a flexible message with a flood, and a device that handles one frame per read.
#include <gateway/outbox.hpp>
#include <gateway/pacer.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace setpoints_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::Duration;
using ano::TimePoint;
using support::Bytes;

namespace {

constexpr std::uint8_t setpoint_id = 0xF5;

struct Leaving {
    TimePoint begin, end;    // on the wire
};

// An outbox, a pacer, and a wire with `rate`; timers are up to 1 ms late.
class SlowLine {
public:
    SlowLine(std::uint32_t rate, Duration gap, std::uint64_t seed, std::size_t flush_bytes = 0)
        : rate_{rate}, outbox_{{.flush_bytes = flush_bytes}}, pacer_{{.rate = rate, .gap = gap}}, random_{seed} {
        outbox_.open();
    }

    void push(std::uint8_t id, std::size_t data, QueuePolicy policy, std::uint8_t channel) {
        Bytes bytes(data);
        const auto at = now.time_since_epoch().count();
        std::memcpy(bytes.data(), &at, sizeof at);
        outbox_.push(ano::FrameView{support::frame(0xFE, 0xDC, id, bytes)}, policy, now, ChannelId{channel});
    }
    bool flush_parser() { return outbox_.flush_parser(now); }
    void flush() {
        std::array<std::span<const std::uint8_t>, 64> pieces;
        for (;;) {
            const auto next = outbox_.next(now);
            if (next.size == 0) return;
            const std::size_t count = outbox_.gather(pieces, now,
                                                     pacer_.allowance(next.is_zeros ? 1 : next.size, next.urgent, now));
            if (count == 0) break;
            most_in_a_write = std::max(most_in_a_write, count);
            std::size_t bytes = 0;
            for (std::size_t i = 0; i < count; ++i) bytes += send(pieces[i]);
            outbox_.sent(bytes);
            pacer_.sent(bytes, now);
        }
        outbox_.set_congested();
        const auto waiting = outbox_.next(now);
        timer = pacer_.next_at(waiting.is_zeros ? 1 : waiting.size) + random_.below(1000u) * 1us;
    }
    bool is_balanced() const { return unaccounted(outbox_.counters()) == outbox_.waiting(); }

    TimePoint now{1s};
    TimePoint timer = TimePoint::max();
    std::vector<Duration> ages;    // of setpoints, when their last byte was sent
    std::vector<Leaving> leavings;
    std::size_t most_in_a_write = 0;
    std::size_t zeros = 0;

private:
    std::size_t send(std::span<const std::uint8_t> frame) {
        const TimePoint begin = std::max(idle_at_, now);
        idle_at_ = begin + Duration{std::chrono::seconds{frame.size()}} / rate_;
        if (frame[0] == 0) {
            zeros += frame.size();
            return frame.size();
        }
        leavings.push_back({begin, idle_at_});
        Duration::rep born;
        std::memcpy(&born, frame.data() + ano::header_size, sizeof born);
        if (frame[3] == setpoint_id) ages.push_back(idle_at_ - TimePoint{Duration{born}});
        return frame.size();
    }

    std::uint32_t rate_;
    Outbox outbox_;
    Pacer pacer_;
    TimePoint idle_at_{};
    support::Random random_;
};

// 50 setpoints of 8 bytes a second, and another program that sends four times the capacity of a line of 9600 baud.
void run(SlowLine& line, QueuePolicy setpoints) {
    TimePoint next_setpoint = line.now, next_other = line.now;
    for (const TimePoint end = line.now + 60s; line.now < end;) {
        line.now = std::min({next_setpoint, next_other, line.timer});
        if (line.now == line.timer) line.timer = TimePoint::max();
        if (line.now == next_setpoint) {
            line.push(setpoint_id, 8, setpoints, 1);
            next_setpoint += 20ms;
        }
        if (line.now == next_other) {
            line.push(0xF1, 22, policy_of(0xF1), 2);
            next_other += 7812us;
        }
        line.flush();
    }
}

Duration median(std::vector<Duration> ages) {
    std::nth_element(ages.begin(), ages.begin() + static_cast<std::ptrdiff_t>(ages.size() / 2), ages.end());
    return ages.at(ages.size() / 2);
}

TEST(Setpoints, in_a_flexible_message_arrive_fresh_over_9600_baud_despite_a_flood) {
    SlowLine line{960, {}, 1};
    run(line, policy_of(ClassSettings{setpoint_id, FrameClass::control, true, 200ms}));
    EXPECT_LT(median(line.ages), 60ms);
    EXPECT_LT(*std::max_element(line.ages.begin(), line.ages.end()), 200ms);
    EXPECT_GT(line.ages.size(), 60u * 25) << "more than every second one";
    EXPECT_TRUE(line.is_balanced());
    RecordProperty("median_us", static_cast<int>(median(line.ages) / 1us));

    SlowLine usual{960, {}, 1};
    run(usual, policy_of(setpoint_id));
    EXPECT_GT(median(usual.ages), 500ms) << "why the class can be configured";
    RecordProperty("median_without_class_us", static_cast<int>(median(usual.ages) / 1us));
}

// 206 zero bytes before a repeated request take 0.86 s at 2400 baud.
TEST(Setpoints, do_not_wait_for_the_zero_bytes_of_a_flush) {
    SlowLine line{240, {}, 2, 206};
    TimePoint next_setpoint = line.now, next_request = line.now + 130ms;
    unsigned flushes = 0;
    for (const TimePoint end = line.now + 60s; line.now < end;) {
        line.now = std::min({next_setpoint, next_request, line.timer});
        if (line.now == line.timer) line.timer = TimePoint::max();
        if (line.now == next_setpoint) {
            line.push(setpoint_id, 8, policy_of(ClassSettings{setpoint_id, FrameClass::control, true, 200ms}), 1);
            next_setpoint += 250ms;
        }
        if (line.now == next_request) {
            flushes += line.flush_parser();
            line.push(0xE0, 8, policy_of(0xE0), 2);
            next_request += 1100ms;
        }
        line.flush();
    }
    EXPECT_GE(flushes, 30u);
    EXPECT_GT(line.zeros, flushes * 10u) << "a part of them leaves";
    EXPECT_GE(line.ages.size(), 239u) << "none is too old";
    EXPECT_LE(*std::max_element(line.ages.begin(), line.ages.end()), 180ms) << "two frames and what the driver has";
    RecordProperty("worst_ms", static_cast<int>(*std::max_element(line.ages.begin(), line.ages.end()) / 1ms));
    EXPECT_TRUE(line.is_balanced());
}

TEST(Setpoints, with_a_gap_are_written_one_frame_at_a_time_with_a_pause_after_each) {
    for (const std::uint32_t rate : {960u, 11'520u, 50'000u}) {
        SlowLine line{rate, 15ms, rate};
        run(line, policy_of(ClassSettings{setpoint_id, FrameClass::control}));
        EXPECT_EQ(line.most_in_a_write, 1u);
        ASSERT_GT(line.leavings.size(), 900u);
        for (std::size_t i = 1; i < line.leavings.size(); ++i)
            ASSERT_GE(line.leavings[i].begin - line.leavings[i - 1].end, 15ms) << i << " at " << rate;
        EXPECT_TRUE(line.is_balanced());
    }
}

}    // namespace
}    // namespace setpoints_tests
