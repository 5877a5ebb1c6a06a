// A queue of questions before an outbox. Whatever is received, sent, answered, fails or expires: at most eight questions are
// unanswered, commands and all other frames never wait for them, the questions of one channel keep their order, channels take
// turns, and every frame is accounted for.
#include <gateway/question_queue.hpp>

#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <map>

namespace questions_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::Random;

namespace {

constexpr std::uint8_t host = 0xFE, fc = 0xDC;

Bytes question(std::uint16_t n) {
    return support::frame(host, fc, 0xE0, {2, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}
Bytes answer(std::uint16_t n) {
    return support::frame(fc, host, 0xE1, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8), 1});
}
std::uint16_t number(const Bytes& question) { return static_cast<std::uint16_t>(question[7] | question[8] << 8); }

Bytes other_frame(Random& random) {
    const auto id = random.of<std::uint8_t>({0xC0, 0x40, 0x41, 0xE1, 0x61, 0x03, 0xA0, 0xB0});
    Bytes data(random.below(30u));
    for (auto& byte : data) byte = random.byte();
    return support::frame(host, fc, id, data);
}

// The device at the other end, and its state.
struct Device {
    std::map<std::uint16_t, ano::TimePoint> unanswered;
    std::deque<Bytes> others;
    int last = -1;
    int channels = 1;                    // of the questions; derived from their numbers
    std::map<int, int> left, last_of;    // by channel

    void receive(const Bytes& frame, ano::TimePoint now) {
        if (!question_in(ano::FrameView{frame})) return others.push_back(frame);
        last = number(frame);
        const int channel = last % channels;
        ASSERT_TRUE(left[channel]++ == 0 || last > last_of[channel]) << "in the order in which the channel asked them";
        last_of[channel] = last;
        for (auto it = unanswered.begin(); it != unanswered.end();)
            it = now >= it->second + InFlight::patience ? unanswered.erase(it) : std::next(it);
        unanswered[number(frame)] = now;
        // Those replaced by another sender's question may still be answered.
        const auto recent = std::count_if(unanswered.begin(), unanswered.end(),
                                          [&](const auto& one) { return now < one.second + InFlight::early; });
        ASSERT_LE(static_cast<std::size_t>(recent), InFlight::max_questions);
        ASSERT_LE(unanswered.size(), InFlight::max_questions + static_cast<std::size_t>(channels));
    }
};

class Line {
public:
    explicit Line(const QuestionQueue::Options& options) : queue{outbox, options} { outbox.open(); }

    // The `n`th question of a channel.
    void ask(int channel, int n) {
        push(question(static_cast<std::uint16_t>(n * device.channels + channel)), static_cast<ChannelId>(channel));
    }
    void push(const Bytes& frame, ChannelId from = ourselves) {
        ++offered;
        const std::size_t before = outbox.waiting();
        const bool waits = question_in(ano::FrameView{frame}).has_value();
        const auto allocated = support::allocations;
        queue.push(ano::FrameView{frame}, policy_of(frame[3]), now, from);
        ASSERT_EQ(support::allocations, allocated);
        if (!waits && !tight) {
            ASSERT_EQ(outbox.waiting(), before + 1) << "only questions wait";
        }
    }
    void send(std::size_t most) {
        std::array<std::span<const std::uint8_t>, 16> pieces;
        const std::size_t count = outbox.gather(std::span{pieces}.first(std::min(most, pieces.size())), now);
        std::vector<Bytes> frames;
        for (std::size_t i = 0; i < count; ++i) frames.emplace_back(pieces[i].begin(), pieces[i].end());
        for (const Bytes& frame : frames) {
            outbox.sent_frame();
            device.receive(frame, now);
        }
    }
    void reply(Random& random) {
        if (device.unanswered.empty()) return;
        auto one = device.unanswered.begin();
        std::advance(one, random.below(device.unanswered.size()));
        const Bytes frame = answer(one->first);
        device.unanswered.erase(one);
        queue.receive(ano::FrameView{frame}, now);
    }
    void close() {
        outbox.close();
        queue.close();
        device.unanswered.clear();    // it restarts
    }
    void expect_accounted() {
        SendCounters all = outbox.counters();
        add(all, queue.counters());
        ASSERT_EQ(all.offered, offered);
        ASSERT_EQ(unaccounted(all), outbox.waiting() + queue.waiting());
        ASSERT_EQ(unaccounted(queue.counters()), queue.waiting());
        ASSERT_LE(queue.in_flight(), InFlight::max_questions);
        ASSERT_EQ(queue.next_look(now).has_value(), queue.waiting() > 0) << "or it would wait for ever";
    }

    ano::TimePoint now{1h};
    Outbox outbox{{.bytes = 4096, .max_data = 198}};
    QuestionQueue queue;
    Device device;
    std::uint64_t offered = 0;
    bool tight = false;    // the outbox may be full
};

TEST(Questions, are_all_accounted_for_after_random_events) {
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        Random random{seed};
        Line line{{.bytes = 400, .age = 5s}};
        line.tight = true;
        line.device.channels = 4;
        std::array<int, 4> asked{};
        for (int step = 0; step < 600; ++step) {
            switch (random.below(8)) {
            case 0:
            case 1: {
                const std::size_t channel = random.one_in(2) ? 0u : random.below(4u);
                line.ask(static_cast<int>(channel), asked[channel]++);
                break;
            }
            case 2: line.push(other_frame(random)); break;
            case 3: line.send(random.below(16u)); break;
            case 4: line.reply(random); break;
            case 5: line.now += std::chrono::milliseconds{random.below(random.one_in(10) ? 3000 : 60)}; break;
            case 6: line.queue.release(line.now); break;
            case 7:
                if (random.one_in(20)) line.outbox.is_open() ? line.close() : line.outbox.open();
                else if (random.one_in(10)) line.outbox.set_congested();
                else if (!line.outbox.empty() && random.one_in(10)) line.outbox.drop_frame(&SendCounters::send_failed);
                break;
            }
            line.expect_accounted();
            if (HasFatalFailure()) FAIL() << "seed " << seed << ", step " << step;
        }
    }
}

TEST(Questions, are_all_sent_if_the_device_answers) {
    Line line{{}};
    Random random{1};
    for (std::uint16_t n = 0; n < 300; ++n) line.push(question(n));
    while (line.device.last < 299) {
        line.send(16);
        ASSERT_FALSE(line.device.unanswered.empty());
        line.reply(random);
        line.now += 5ms;
    }
    EXPECT_EQ(line.queue.waiting() + line.outbox.waiting(), 0u);
    EXPECT_EQ(line.outbox.counters().frames_out, 300u) << "nothing lost";
}

// Three channels flood, the fourth asks one question at a time.
TEST(Questions, of_a_channel_with_few_requests_are_sent_in_turn_despite_a_flood) {
    for (std::uint64_t seed = 0; seed < support::trials(10); ++seed) {
        Random random{seed};
        Line line{{.bytes = 4096}};
        line.tight = true;
        line.device.channels = 4;
        std::array<int, 4> asked{};
        std::map<int, int> left_before;
        for (int step = 0; step < 600; ++step) {
            for (int n = 0; n < 3; ++n) {
                const std::size_t channel = random.below(3u);
                line.ask(static_cast<int>(channel), asked[channel]++);
            }
            if (line.device.left[3] == asked[3] && random.one_in(20)) {
                line.ask(3, asked[3]++);
                left_before = line.device.left;
            }
            line.send(16);
            line.reply(random);
            line.send(16);
            line.now += 5ms;
            line.expect_accounted();
            if (HasFatalFailure()) FAIL() << "seed " << seed << ", step " << step;
            if (line.device.left[3] == asked[3]) continue;
            for (int other = 0; other < 3; ++other)
                ASSERT_LE(line.device.left[other] - left_before[other], 2) << "seed " << seed << ", step " << step;
        }
        EXPECT_GT(asked[3], 10) << "seed " << seed;
        EXPECT_GT(line.queue.counters().queue_full, 500u);
    }
}

TEST(Questions, of_the_channel_with_most_waiting_are_dropped_oldest_first) {
    Line line{{.bytes = 1000}};
    line.device.channels = 2;
    for (int n = 0; n < 8; ++n) line.ask(0, n);    // sent, not yet answered
    for (int n = 0; n < 5; ++n) line.ask(1, n);
    for (int n = 8; n < 400; ++n) line.ask(0, n);
    const std::uint64_t full = line.queue.counters().queue_full;
    EXPECT_GT(full, 0u);
    Random random{1};
    int first = -1;
    while (line.send(16), !line.device.unanswered.empty()) {
        if (first < 0 && line.device.left[0] > 8) first = line.device.last_of[0];
        line.reply(random);
    }
    EXPECT_EQ(line.device.left[1], 5);
    EXPECT_EQ(line.device.left[0] + static_cast<int>(full), 400);
    EXPECT_EQ(line.device.last_of[0], 399 * 2);
    EXPECT_EQ(first, (8 + static_cast<int>(full)) * 2) << "its oldest gave way";
    line.expect_accounted();
}

TEST(Questions, of_large_size_are_dropped_before_the_few_small_ones_of_another_channel) {
    Line line{{.bytes = 1000}};
    line.device.channels = 2;
    for (int n = 0; n < 8 + 10; ++n) line.ask(1, n);
    Bytes data(150);
    data[0] = 2;
    for (std::uint8_t n = 0; n < 100; ++n) {
        data[1] = static_cast<std::uint8_t>(2 * (n % 100));
        line.push(support::frame(host, fc, 0xE0, data), ChannelId{0});
    }
    Random random{1};
    while (line.send(16), !line.device.unanswered.empty()) line.reply(random);
    EXPECT_EQ(line.device.left[1], 18);
    EXPECT_GT(line.device.left[0], 2);
}

TEST(Questions, after_the_eighth_are_sent_half_a_second_later_without_answers) {
    Line line{{}};
    for (std::uint16_t n = 0; n < 9; ++n) line.push(question(n));
    line.send(16);
    EXPECT_EQ(line.device.last, 7);
    EXPECT_EQ(line.queue.next_look(line.now), line.now + 500ms);
    line.now += 499ms;
    EXPECT_FALSE(line.queue.release(line.now));
    line.now += 1ms;
    EXPECT_TRUE(line.queue.release(line.now));
    line.send(16);
    EXPECT_EQ(line.device.last, 8);
}

TEST(Questions, are_overtaken_by_commands_and_sticks_while_they_wait) {
    Line line{{}};
    for (std::uint16_t n = 0; n < 20; ++n) line.push(question(n));
    line.send(16);
    for (const std::uint8_t id : std::initializer_list<std::uint8_t>{0xC0, 0x40, 0x41, 0xE1})
        line.push(support::frame(host, fc, id, Bytes(11)));
    line.push(support::frame(host, fc, 0xE0, {0x10, 0xAB, 0}));
    line.send(16);
    EXPECT_EQ(line.device.others.size(), 5u);
    EXPECT_EQ(line.queue.waiting(), 12u);
}

TEST(Questions, age_from_the_time_of_arrival) {
    Line line{{.age = 5s}};
    for (std::uint16_t n = 0; n < 9; ++n) line.push(question(n));    // nothing is sent
    line.now += 4999ms;
    EXPECT_EQ(line.queue.next_look(line.now), line.now + 1ms);
    EXPECT_FALSE(line.queue.release(line.now));
    EXPECT_EQ(line.queue.waiting(), 1u);
    line.now += 1ms;
    EXPECT_FALSE(line.queue.release(line.now));
    EXPECT_EQ(line.queue.counters().stale, 1u);
    EXPECT_EQ(line.queue.next_look(line.now), std::nullopt);
}

TEST(Questions, keep_their_age_when_they_move_to_the_outbox) {
    Line line{{.age = 5s}};
    for (std::uint16_t n = 0; n < 9; ++n) line.push(question(n));
    line.send(16);
    line.now += 4s;
    EXPECT_TRUE(line.queue.release(line.now));
    line.now += 1s;
    line.send(16);
    EXPECT_EQ(line.device.last, 7);
    EXPECT_EQ(line.outbox.counters().stale, 1u);
    EXPECT_EQ(line.queue.in_flight(), 0u);
}

TEST(Questions, are_dropped_when_the_link_closes_and_new_ones_are_sent_after_it_opens) {
    Line line{{}};
    for (std::uint16_t n = 0; n < 12; ++n) line.push(question(n));
    line.send(3);
    line.close();
    EXPECT_EQ(line.queue.counters().link_down, 4u);
    EXPECT_EQ(line.outbox.counters().link_down, 5u);
    line.push(question(12));
    EXPECT_EQ(line.outbox.counters().link_down, 6u);
    line.outbox.open();
    for (std::uint16_t n = 13; n < 21; ++n) line.push(question(n));
    EXPECT_EQ(line.outbox.waiting(), 8u);
    line.expect_accounted();
}

}    // namespace
}    // namespace questions_tests
