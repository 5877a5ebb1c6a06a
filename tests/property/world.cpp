// A simulated world with any input: equal seeds and equal frames at equal times result in equal bytes; it sends whole frames of
// its own; and it answers each frame at most once.
#include <world/faulty_line.hpp>
#include <world/kinds.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

namespace world_tests {

namespace {

using namespace ano::world;
using namespace std::chrono_literals;
using support::Bytes;
using support::Random;

constexpr ano::TimePoint start{1000s};

std::unique_ptr<SimulatedDevice> any_device(Random& random) {
    const ano::world::Settings settings{0, random.of({1u, 7u, 50u, 100u}), random.below(1000u)};
    return make_device(random.of<std::string_view>({"fc", "fc", "imu", "flow", "radio", "car"}), settings, start);
}

// Frames by which hosts write, command and steer.
Bytes random_frame(Random& random, std::uint8_t from, std::uint8_t to) {
    const auto id = random.of<std::uint8_t>(
        {0xE1, 0xE1, 0xC0, 0xC0, 0xE0, 0x61, 0x60, 0x40, 0x41, 0xC1, 0xF0, 0x00, random.byte()});
    Bytes data{static_cast<std::uint8_t>(random.below(160u)), 0};
    if (id == 0xC0) data = {random.of<std::uint8_t>({0x10, 0x20}), 0, static_cast<std::uint8_t>(random.below(14u))};
    if (id == 0xE0)
        data = {random.of<std::uint8_t>({0, 1, 2, 3, 0x10}), random.of<std::uint8_t>({0xAA, 0xAB, 0x20, 0x21, 0x30, 0x31}), 0};
    if (id == 0xC1) data = {random.of<std::uint8_t>({0, 1}), random.below<std::uint8_t>(14), 0};
    for (std::size_t i = random.below(32u); i-- > 0;)
        data.push_back(random.of<std::uint8_t>({0, 1, 2, 5, 0x7F, 0x80, 0xFF, random.byte()}));
    return support::frame(from, to, id, data);
}

struct TimedFrame {
    ano::TimePoint at;
    Bytes frame;    // empty: none
};

std::vector<TimedFrame> random_timed_frames(Random& random, std::uint8_t to) {
    std::vector<TimedFrame> timed_frames;
    ano::TimePoint at = start;
    for (int i = 0; i < 60; ++i) {
        at += random.of<ano::Duration>({0ms, 1ms, 13ms, 100ms, 900ms});
        timed_frames.push_back({at, random_frame(random, 0xFE, to)});
    }
    return timed_frames;
}

Faults any_faults(Random& random) {
    Faults faults;
    if (random.one_in(3)) return faults;
    const auto late = [&] { return random.of<ano::Duration>({0ms, 0ms, 7ms, 150ms}); };
    faults.loss = random.below(30u);
    faults.duplicate = random.below(30u);
    faults.corrupt = random.below(30u);
    faults.delay = late();
    faults.jitter = late();
    faults.slow = late();
    if (random.one_in(4)) faults.deaf_after = 5s;
    return faults;
}

// All bytes sent by a new device that receives random_timed_frames(), with the time of each frame; run in steps chosen by `steps`.
Bytes all_sent(std::uint64_t seed, std::uint64_t steps) {
    Random random{seed};
    auto device = any_device(random);
    const auto timed_frames = random_timed_frames(random, device->device().info().id);
    FaultyLine line{std::move(device), any_faults(random), seed, start};
    Bytes said;
    const FaultyLine::Send receive = [&](ano::Bytes bytes, ano::TimePoint at) {
        said.insert(said.end(), bytes.begin(), bytes.end());
        for (auto us = (at - start) / 1us; us != 0; us /= 256) said.push_back(static_cast<std::uint8_t>(us % 256));
    };
    Random step{steps};
    ano::TimePoint now = start;
    for (const TimedFrame& timed : timed_frames) {
        while (now < timed.at) {
            now = std::min(timed.at, now + step.of<ano::Duration>({1ms, 3ms, 20ms, 333ms, 2s}));
            line.run(now, receive);
        }
        line.take(ano::FrameView{timed.frame}, timed.at, receive);
    }
    return said;
}

TEST(World, sends_the_same_bytes_for_a_seed_whatever_the_time_steps) {
    for (std::uint64_t seed = 0; seed < 25; ++seed) {
        const Bytes said = all_sent(seed, 1);
        ASSERT_GT(said.size(), 300u);
        ASSERT_EQ(said, all_sent(seed, 2)) << "seed " << seed;
    }
}

TEST(World, differs_by_seed) {
    const auto bytes_of = [](std::uint64_t seed) {
        Bytes said;
        make_device("fc", {0, 50, seed}, start)->run(start + 1s, [&](ano::Bytes f, ano::TimePoint) {
            said.insert(said.end(), f.begin(), f.end());
        });
        return said;
    };
    EXPECT_EQ(bytes_of(7), bytes_of(7));
    EXPECT_NE(bytes_of(7), bytes_of(8));
}

TEST(World, sends_complete_frames_from_its_id_at_increasing_times) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Random random{seed};
        const auto device = any_device(random);
        const std::uint8_t id = device->device().info().id;
        ano::TimePoint last = start;
        std::size_t said = 0;
        const SimulatedDevice::Send receive = [&](ano::Bytes bytes, ano::TimePoint at) {
            ++said;
            ASSERT_TRUE(ano::frame_at(bytes)) << "seed " << seed;
            const ano::FrameView frame{bytes};
            ASSERT_EQ(frame.source(), id);
            ASSERT_LE(frame.data().size(), 198u);
            ASSERT_GE(at, last);
            last = at;
        };
        for (const TimedFrame& timed : random_timed_frames(random, id)) {
            device->take(ano::FrameView{timed.frame}, timed.at, receive);
            ASSERT_LE(last, timed.at);
            device->run(timed.at, receive);
            ASSERT_GT(device->due(), timed.at);
        }
        ASSERT_GT(said, 10u);
    }
}

// Of the frames sent at once after a run(), all except logs count: telemetry is sent by run().
TEST(World, answers_every_frame_at_most_once) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Random random{seed};
        const auto device = any_device(random);
        for (const TimedFrame& timed : random_timed_frames(random, device->device().info().id)) {
            device->run(timed.at, [](ano::Bytes, ano::TimePoint) {});
            int answers = 0;
            device->take(ano::FrameView{timed.frame}, timed.at,
                         [&](ano::Bytes f, ano::TimePoint) { answers += f[3] != 0xA0 && f[3] != 0xA1; });
            ASSERT_LE(answers, 1) << "seed " << seed;
        }
    }
}

// Two worlds that receive all frames of each other, whatever their destination: except for telemetry, no frame starts an
// exchange.
TEST(World, causes_no_storm_with_a_second_one) {
    for (std::uint64_t seed = 0; seed < 15; ++seed) {
        Random random{seed};
        const auto a = any_device(random);
        const auto b = make_device(random.of<std::string_view>({"fc", "car", "imu"}), {0x21, 50, seed}, start);
        ano::TimePoint now = start;
        for (int i = 0; i < 50; ++i, now += 7ms) {
            const auto ignore = [](ano::Bytes, ano::TimePoint) {};
            a->run(now, ignore);
            b->run(now, ignore);
            std::deque<Bytes> line{random_frame(random, a->device().info().id, 0x21)};
            for (std::size_t heard = 0; !line.empty(); ++heard) {
                ASSERT_LE(heard, 4u) << "seed " << seed;
                const Bytes frame = line.front();
                line.pop_front();
                const auto receive = [&](ano::Bytes f, ano::TimePoint) { line.emplace_back(f.begin(), f.end()); };
                a->take(ano::FrameView{frame}, now, receive);
                b->take(ano::FrameView{frame}, now, receive);
            }
        }
    }
}

}    // namespace
}    // namespace world_tests
