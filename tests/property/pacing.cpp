// A slow line that is offered four times its rate: an outbox and a pacer, a wire with transmission times, late timers.
#include <gateway/outbox.hpp>
#include <gateway/pacer.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace pacing_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::Duration;
using ano::TimePoint;
using support::Bytes;

namespace {

constexpr std::uint32_t rate = 11520;    // 115200 baud, 8N1
constexpr QueuePolicy urgent{TrafficClass::urgent, Replaces::nothing, AgeKind::rest};
constexpr QueuePolicy telemetry{TrafficClass::telemetry, Replaces::same_id, AgeKind::telemetry};

// The driver and the wire after it: bytes leave one by one at `rate`.
struct Wire {
    TimePoint idle_at{};
    Duration busy{};
    Duration max_ahead{};

    // Returns the time at which the last of `bytes` has left.
    TimePoint write(std::size_t bytes, TimePoint now) {
        const Duration time = Duration{std::chrono::seconds{bytes}} / rate;
        idle_at = std::max(idle_at, now) + time;
        busy += time;
        max_ahead = std::max(max_ahead, idle_at - now);
        return idle_at;
    }
};

struct Delay {
    std::vector<Duration> all;
    Duration percentile_98() {
        std::sort(all.begin(), all.end());
        return all.at(all.size() * 98 / 100);
    }
};

struct Line {
    explicit Line(std::uint64_t seed) : random{seed} { outbox.open(); }

    void push(std::uint8_t id, std::size_t data, QueuePolicy policy) {
        Bytes bytes(data);
        const auto at = now.time_since_epoch().count();
        std::memcpy(bytes.data(), &at, sizeof at);
        outbox.push(ano::FrameView{support::frame(0xDC, 0xFE, id, bytes)}, policy, now);
    }
    // The work of a link when it may send.
    void flush() {
        std::array<std::span<const std::uint8_t>, 64> pieces;
        for (;;) {
            const auto next = outbox.next(now);
            if (next.size == 0) return;
            const std::size_t count = outbox.gather(pieces, now, pacer.allowance(next.size, next.urgent, now));
            if (count == 0) break;
            std::size_t bytes = 0;
            for (std::size_t i = 0; i < count; ++i) {
                Duration::rep born;
                std::memcpy(&born, pieces[i].data() + ano::header_size, sizeof born);
                const TimePoint left = wire.write(pieces[i].size(), now);
                const bool is_urgent = pieces[i][3] == 0xE1;
                (is_urgent ? urgent_delay : telemetry_delay).all.push_back(left - TimePoint{Duration{born}});
                bytes += pieces[i].size();
            }
            outbox.sent(bytes);
            pacer.sent(bytes, now);
            ++writes;
        }
        outbox.set_congested();
        timer = pacer.next_at(outbox.next(now).size) + random.below(2000u) * 1us;
    }
    // Offers `kinds` telemetry ids, and an urgent frame now and then.
    void run(Duration time, unsigned kinds, std::size_t offered_rate) {
        const Duration gap = Duration{21s} / offered_rate;    // between frames of 21 bytes
        TimePoint next_urgent = now + 50ms;
        TimePoint next_telemetry = now;
        for (const TimePoint end = now + time; now < end;) {
            now = std::min({next_urgent, next_telemetry, timer});
            if (now == timer) timer = TimePoint::max();
            if (now == next_telemetry) {
                push(static_cast<std::uint8_t>(1 + pushed++ % kinds), 13, telemetry);
                next_telemetry += gap;
            }
            if (now == next_urgent) {
                push(0xE1, 13, urgent);
                next_urgent += 20ms + random.below(60u) * 1ms;
            }
            flush();
        }
    }

    support::Random random;
    Outbox outbox{{}};
    Pacer pacer{{.rate = rate}};
    Wire wire;
    TimePoint now{};
    TimePoint timer = TimePoint::max();
    Delay urgent_delay;
    Delay telemetry_delay;
    unsigned pushed = 0;
    std::size_t writes = 0;
};

TEST(Pacing, an_overloaded_line_is_fully_used_with_fresh_telemetry_and_short_urgent_delay) {
    for (const unsigned kinds : {1u, 6u, 15u, 24u}) {
        SCOPED_TRACE(testing::Message() << kinds << " kinds");
        Line line{kinds};
        line.run(20s, kinds, 4 * rate);
        EXPECT_LE(line.urgent_delay.percentile_98(), 45ms);
        EXPECT_LE(line.telemetry_delay.percentile_98(), 80ms);
        EXPECT_GE(line.wire.busy, 20s * 85 / 100);
        EXPECT_LE(line.wire.max_ahead, 20ms) << "never overrun";
        if (kinds > 1) {
            EXPECT_LE(line.writes, 20u * 160) << "about one write each half latency";
        }
        EXPECT_EQ(unaccounted(line.outbox.counters()), line.outbox.waiting());
        RecordProperty("urgent_98_us", static_cast<int>(line.urgent_delay.percentile_98() / 1us));
        RecordProperty("telemetry_98_us", static_cast<int>(line.telemetry_delay.percentile_98() / 1us));
    }
}

TEST(Pacing, light_traffic_does_not_wait) {
    Line line{1};
    line.run(20s, 6, rate / 2);
    EXPECT_LE(line.telemetry_delay.percentile_98(), 10ms);
    EXPECT_EQ(line.outbox.counters().superseded, 0u);
}

// A machine that slept, a clock that was set: nothing stalls, the line is never overrun, every dropped frame has its cause.
TEST(Pacing, a_clock_jump_stops_no_frame_and_every_dropped_frame_is_counted) {
    support::Random random{5};
    Outbox outbox{{}};
    outbox.open();
    Pacer pacer{{.rate = rate}};
    TimePoint now{48h};
    std::array<std::span<const std::uint8_t>, 64> pieces;
    for (int step = 0; step < 200'000; ++step) {
        now += random.one_in(100) ? random.of<Duration>({-3h, -1s, -5ms, 100ms, 1s, 3h}) : Duration{random.below(4u) * 1ms};
        const QueuePolicy policy = random.one_in(5) ? urgent : telemetry;
        outbox.push(ano::FrameView{support::frame(0xDC, 0xFE, random.byte(), Bytes(random.below(std::size_t{30})))}, policy, now);
        const auto next = outbox.next(now);
        ASSERT_GT(next.size, 0u);
        const std::size_t budget = pacer.allowance(next.size, next.urgent, now);
        if (budget == 0) {
            ASSERT_LE(pacer.next_at(next.size) - now, 20ms) << "more may go soon";
            outbox.set_congested();
            continue;
        }
        std::size_t bytes = 0;
        const std::size_t count = outbox.gather(pieces, now, budget);
        ASSERT_GT(count, 0u);
        for (const auto piece : std::span{pieces}.first(count)) bytes += piece.size();
        ASSERT_LE(bytes, rate / 50 + 38) << "what the line carries in 20 ms, or one frame";
        outbox.sent(bytes);
        pacer.sent(bytes, now);
        ASSERT_EQ(unaccounted(outbox.counters()), outbox.waiting());
    }
    EXPECT_GT(outbox.counters().frames_out, 100'000u / 10);
}

}    // namespace
}    // namespace pacing_tests
