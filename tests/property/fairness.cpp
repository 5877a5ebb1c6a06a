// Waiting times as arithmetic: senders that offer a slow line more than its capacity, and one that does not; classes in random
// mixes. The figures are those of the floods in which commands of a third host were lost.
#include <gateway/outbox.hpp>
#include <gateway/pacer.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

namespace fairness_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::Duration;
using ano::TimePoint;
using support::Bytes;

namespace {

constexpr QueuePolicy urgent{TrafficClass::urgent, Replaces::nothing, AgeKind::rest};
constexpr ChannelId third_channel{7};
constexpr std::uint8_t third_id = 0xC0;

// Writes of parameters: 14 bytes each.
struct Flooder {
    ChannelId channel;
    std::uint8_t addresses;    // it cycles through this number of addresses, from `first` down
    std::uint8_t first;
    Duration gap;
};

// A paced line as a link drives it: frames that may be sent are gathered, and begin to leave at once after those before them.
struct Line {
    explicit Line(std::uint32_t line_rate) : rate{line_rate}, pacer{{.rate = line_rate}} { outbox.open(); }

    struct Waited {
        std::size_t frames = 0;    // sent between its arrival and its own turn
        Duration time{};           // until its first byte was sent
    };

    void flush() {
        std::array<std::span<const std::uint8_t>, 64> pieces;
        for (;;) {
            const auto next = outbox.next(now);
            if (next.size == 0) return;
            const std::size_t count = outbox.gather(pieces, now, pacer.allowance(next.size, next.urgent, now));
            if (count == 0) break;
            std::size_t bytes = 0;
            for (const auto piece : std::span{pieces}.first(count)) {
                ++left;
                idle_at = std::max(idle_at, now);
                if (piece[3] == third_id) arrived(idle_at);
                idle_at += Duration{std::chrono::seconds{piece.size()}} / rate;
                bytes += piece.size();
            }
            outbox.sent(bytes);
            pacer.sent(bytes, now);
        }
        outbox.set_congested();
        timer = std::max(pacer.next_at(outbox.next(now).size), now + 100us);    // time advances
    }
    void arrived(TimePoint at) {
        ASSERT_FALSE(commands.empty());
        most.frames = std::max(most.frames, left - 1 - commands.front().left_before);
        most.time = std::max(most.time, at - commands.front().at);
        commands.pop_front();
        ++commands_left;
    }
    void command(std::uint8_t source, ChannelId channel) {
        commands.push_back({now, left});
        outbox.push(ano::FrameView{support::frame(source, 0xDC, third_id, Bytes(11))}, urgent, now, channel);
    }
    // Runs the flooders for 19 s, and a command of the third every 100 ms.
    void run(const std::vector<Flooder>& flooders, std::uint8_t third, ChannelId channel) {
        std::vector<TimePoint> next(flooders.size(), now);
        TimePoint next_command = now + 50ms;
        unsigned n = 0;
        for (const TimePoint end = now + 19s; now < end;) {
            now = std::min({*std::min_element(next.begin(), next.end()), next_command, timer});
            if (now == timer) timer = TimePoint::max();
            for (std::size_t f = 0; f < flooders.size(); ++f) {
                if (next[f] > now) continue;
                const Flooder& flooder = flooders[f];
                const auto source = static_cast<std::uint8_t>(flooder.first - n++ % flooder.addresses);
                outbox.push(ano::FrameView{support::frame(source, 0xDC, 0xE1, Bytes(6))}, urgent, now, flooder.channel);
                next[f] += flooder.gap;
            }
            if (now == next_command) {
                command(third, channel);
                next_command += 100ms;
            }
            flush();
        }
    }

    std::uint32_t rate;
    Outbox outbox{{}};
    Pacer pacer;
    TimePoint now{1h};
    TimePoint timer = TimePoint::max();
    TimePoint idle_at{};
    struct Command {
        TimePoint at;
        std::size_t left_before;
    };
    std::deque<Command> commands;
    std::size_t left = 0;
    std::size_t commands_left = 0;
    Waited most;
};

struct Flood {
    std::uint32_t rate;
    std::vector<Flooder> flooders;
    std::uint8_t third = 0xFE;
    ChannelId channel = third_channel;
};

const Flood floods[] = {
    {960, {{ChannelId{1}, 1, 0xFE, 10ms}, {ChannelId{2}, 1, 0xFE, 10ms}}},
    {11520, {{ChannelId{1}, 1, 0xFE, 1ms}, {ChannelId{2}, 1, 0xFE, 1ms}}},
    {960, {{ChannelId{1}, 250, 0xFE, 5ms}}},
    {11520, {{ChannelId{1}, 250, 0xFE, 500us}}},
    {960, {{ChannelId{1}, 250, 0xFE, 5ms}, {ChannelId{2}, 1, 0xFE, 10ms}}},
    // All of them on one channel, as through another gateway.
    {960, {{third_channel, 1, 30, 10ms}, {third_channel, 1, 31, 10ms}}},
    {11520, {{third_channel, 1, 30, 1ms}, {third_channel, 1, 31, 1ms}}},
};

TEST(Fairness, a_single_command_of_a_third_sender_is_never_lost_and_waits_for_at_most_two_frames) {
    for (const Flood& flood : floods) {
        SCOPED_TRACE(testing::Message() << flood.rate << " bytes/s, flood " << &flood - floods);
        Line line{flood.rate};
        line.run(flood.flooders, flood.third, flood.channel);
        EXPECT_EQ(line.commands_left + line.commands.size(), 190u);
        EXPECT_LE(line.commands.size(), 1u) << "lost, or waits for ever";
        EXPECT_LE(line.most.frames, 2u);
        const Duration two_frames = Duration{std::chrono::seconds{28}} / flood.rate;
        EXPECT_LE(line.most.time, 20ms + two_frames) << "what was given to the driver, and two frames";
        EXPECT_EQ(unaccounted(line.outbox.counters()), line.outbox.waiting());
    }
}

// For any senders: one with large frames, one with small ones, one with many addresses, one that waits until each frame was sent.
TEST(Fairness, channels_that_always_wait_have_equal_shares) {
    for (std::uint64_t seed = 1; seed <= support::trials(5); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        support::Random random{seed};
        Outbox outbox{{}};
        outbox.open();
        const QueuePolicy policy{random.of({TrafficClass::urgent, TrafficClass::telemetry, TrafficClass::bulk}),
                                 Replaces::nothing, AgeKind::rest};
        const unsigned senders = 2 + random.below(6u);
        std::vector<std::size_t> most_data(senders), got(senders), waits(senders);
        for (auto& data : most_data) data = random.of<std::size_t>({4, 20, 100, 1000});
        std::array<std::span<const std::uint8_t>, 64> pieces;
        for (int step = 0; step < 1500; ++step) {
            for (std::size_t s = 0; s < senders; ++s)
                for (; waits[s] < 3000; waits[s] += ano::overhead + most_data[s]) {
                    Bytes data(most_data[s], static_cast<std::uint8_t>(s));
                    const auto source = static_cast<std::uint8_t>(s == 0 ? 1 + random.below(200u) : 0xFE);
                    outbox.push(ano::FrameView{support::frame(source, 0xDC, 0xE1, data)}, policy, TimePoint{},
                                ChannelId{static_cast<std::uint8_t>(s)});
                }
            const std::size_t count = outbox.gather(pieces, TimePoint{}, 600 + random.below(3000u));
            std::size_t leave = random.below(count + 1);
            for (const auto piece : std::span{pieces}.first(leave)) {
                got[piece[ano::header_size]] += piece.size();
                waits[piece[ano::header_size]] -= piece.size();
            }
            for (; leave > 0; --leave) outbox.sent_frame();
        }
        const auto [least, most] = std::minmax_element(got.begin(), got.end());
        EXPECT_LE(*most - *least, 2 * 1008 + 2 * 256u) << "of " << *most;
        EXPECT_EQ(outbox.counters().queue_full, 0u);
    }
}

// Three classes on a line, each offered a multiple of its capacity.
struct Mix {
    struct Class {
        double offered;
        std::size_t size;
        unsigned senders;
        double debt = 0;
        std::size_t pushed = 0;
        std::size_t left = 0;
    };
    std::uint32_t rate;
    std::array<Class, 3> classes;
    Outbox outbox{{}};
    std::size_t total = 0;

    void run(Duration time) {
        constexpr AgeKind ages[] = {AgeKind::rest, AgeKind::telemetry, AgeKind::rest};
        outbox.open();
        TimePoint now{1h};
        unsigned n = 0;
        for (const TimePoint end = now + time; now < end;) {
            std::array<std::span<const std::uint8_t>, 1> piece;
            const bool sends = outbox.gather(piece, now) == 1;
            const std::size_t bytes = sends ? piece[0].size() : 10;    // or the line is idle
            if (sends) {
                classes[piece[0][3]].left += bytes;
                outbox.sent_frame();
                outbox.set_congested();
            }
            total += bytes;
            now += Duration{std::chrono::seconds{bytes}} / rate;
            for (std::size_t c = 0; c < 3; ++c) {
                Class& one = classes[c];
                const Bytes data(one.size - ano::overhead);
                for (one.debt += one.offered * static_cast<double>(bytes); one.debt >= static_cast<double>(one.size);
                     one.debt -= static_cast<double>(one.size)) {
                    const auto from = static_cast<std::uint8_t>(++n % one.senders);
                    outbox.push(ano::FrameView{support::frame(from, 0xFE, static_cast<std::uint8_t>(c), data)},
                                {static_cast<TrafficClass>(c), Replaces::nothing, ages[c]}, now, ChannelId{from});
                    one.pushed += one.size;
                }
            }
        }
    }
    double share(std::size_t c) const { return static_cast<double>(classes[c].left) / static_cast<double>(total); }
    // A tenth, or the offered share if that is less, minus the frames that wait at the end.
    void expect_shares() const {
        for (std::size_t c = 0; c < 3; ++c) {
            const double wanted = std::min(0.1, classes[c].offered);
            const double frames = 3 * static_cast<double>(classes[c].size) / static_cast<double>(total);
            EXPECT_GE(share(c), 0.99 * wanted - frames)
                << ano::traffic_class_names[c] << ": " << classes[c].offered << " offered in frames of " << classes[c].size;
        }
        EXPECT_EQ(unaccounted(outbox.counters()), outbox.waiting());
    }
};

TEST(Shares, of_three_classes_at_three_times_the_line_are_80_10_and_10_percent) {
    Mix mix{11520, {{{3, 14, 1}, {3, 21, 1}, {3, 108, 1}}}};
    mix.run(20s);
    EXPECT_NEAR(mix.share(0), 0.8, 0.01);
    EXPECT_NEAR(mix.share(1), 0.1, 0.01);
    EXPECT_NEAR(mix.share(2), 0.1, 0.01);
}

TEST(Shares, of_telemetry_at_a_fifth_of_the_line_are_at_least_a_tenth) {
    Mix mix{11520, {{{3, 14, 1}, {0.2, 21, 1}, {3, 108, 1}}}};
    mix.run(20s);
    EXPECT_GE(mix.share(1), 0.099);
    EXPECT_GE(mix.share(2), 0.099);
}

TEST(Shares, lose_nothing_of_a_class_below_a_tenth_of_the_line) {
    Mix mix{11520, {{{3, 14, 2}, {0.05, 21, 1}, {0.05, 108, 1}}}};
    mix.run(20s);
    mix.expect_shares();
}

// A tenth of 9600 baud is 96 bytes/s: a frame of 1008 bytes would need ten seconds and is stale after five.
TEST(Shares, pass_the_turn_of_a_stale_frame_to_the_next_frame_of_its_class) {
    Mix mix{960, {{{3, 14, 1}, {3, 208, 1}, {3, 1008, 1}}}};
    mix.run(150s);
    mix.expect_shares();
}

TEST(Shares, are_kept_for_every_mix_of_classes) {
    for (std::uint64_t seed = 1; seed <= support::trials(16) && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        support::Random random{seed};
        Mix mix{random.of<std::uint32_t>({11520, 50000}), {}};
        for (std::size_t c = 0; c < 3; ++c) {
            // At most the bytes that a tenth of the line sends within half of the age of telemetry.
            const std::size_t most = std::min<std::size_t>(c == 2 ? 4104 : 300, mix.rate / 10 / 2 * (c == 2 ? 5 : 1));
            mix.classes[c] = {random.of({0.0, 0.02, 0.05, 0.2, 0.5, 1.0, 3.0}),
                              ano::overhead + random.below(most - ano::overhead), 1 + random.below(10u)};
        }
        mix.run(8s);
        mix.expect_shares();
    }
}

}    // namespace
}    // namespace fairness_tests
