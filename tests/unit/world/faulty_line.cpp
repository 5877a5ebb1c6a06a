// Configured faults between a simulated device and its peer.
#include <world/faulty_line.hpp>
#include <world/kinds.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace faulty_line_tests {
namespace {

using namespace ano::world;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;

constexpr ano::TimePoint start{1000s};

struct Arrived {
    ano::TimePoint at;
    Bytes bytes;
};

struct BadDay {
    explicit BadDay(const Faults& faults, std::string_view kind = "imu", std::uint64_t seed = 1)
        : line{make_device(kind, {0, 50, seed}, start), faults, seed, start} {}

    void run_for(ano::Duration time) {
        for (const auto end = now + time; now < end;) {
            now = std::min(end, line.due());
            line.run(now, receive);
        }
    }
    void ask_who_it_is() {
        const Bytes question = frame(0xFE, line.device().device().info().id, 0xE0, {0, 0, 0});
        line.take(ano::FrameView{question}, now, receive);
    }
    std::size_t count(std::uint8_t id) const {
        return static_cast<std::size_t>(
            std::count_if(arrived.begin(), arrived.end(), [&](const Arrived& a) { return a.bytes[3] == id; }));
    }

    ano::TimePoint now = start;
    std::vector<Arrived> arrived;
    const FaultyLine::Send receive = [this](ano::Bytes bytes, ano::TimePoint at) {
        arrived.push_back({at, {bytes.begin(), bytes.end()}});
    };
    FaultyLine line;
};

TEST(FaultyLine, without_faults_behaves_like_the_device_itself) {
    BadDay day{{}};
    day.run_for(2s);
    std::vector<Arrived> expected;
    make_device("imu", {0, 50, 1}, start)->run(start + 2s, [&](ano::Bytes f, ano::TimePoint at) {
        expected.push_back({at, {f.begin(), f.end()}});
    });
    ASSERT_EQ(day.arrived.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_EQ(day.arrived[i].bytes, expected[i].bytes);
        EXPECT_EQ(day.arrived[i].at, expected[i].at);
    }
    day.ask_who_it_is();
    EXPECT_EQ(day.count(0xE3), 1u) << "at once";
}

TEST(FaultyLine, loses_the_configured_share_in_both_directions) {
    Faults faults;
    faults.loss = 20;
    BadDay day{faults};
    for (int i = 0; i < 1000; ++i) day.ask_who_it_is();
    EXPECT_NEAR(static_cast<double>(day.count(0xE3)), 640, 60);
    EXPECT_NEAR(static_cast<double>(day.line.counters().lost), 360, 60);
}

TEST(FaultyLine, duplicates_the_configured_share_of_frames) {
    Faults faults;
    faults.duplicate = 50;
    BadDay day{faults};
    for (int i = 0; i < 1000; ++i) day.ask_who_it_is();
    EXPECT_NEAR(static_cast<double>(day.count(0xE3)), 2250, 100);
}

TEST(FaultyLine, corrupts_one_bit_in_the_configured_share_of_frames) {
    Faults faults;
    faults.corrupt = 100;
    BadDay day{faults};
    day.run_for(1s);
    ASSERT_GT(day.arrived.size(), 100u);
    for (const Arrived& a : day.arrived) {
        const auto whole = ano::frame_at(a.bytes);
        EXPECT_FALSE(whole && whole->bytes().size() == a.bytes.size());
    }
    const auto said = day.arrived.size();
    day.ask_who_it_is();
    EXPECT_EQ(day.arrived.size(), said) << "a damaged question is none";
    EXPECT_EQ(day.line.counters().damaged, said + 1);
}

TEST(FaultyLine, delays_both_directions_and_jitter_reorders_frames) {
    Faults faults;
    faults.delay = 100ms;
    BadDay day{faults};
    day.ask_who_it_is();
    day.run_for(199ms);
    EXPECT_EQ(day.count(0xE3), 0u);
    day.run_for(1ms);
    EXPECT_EQ(day.count(0xE3), 1u);
    faults.jitter = 200ms;
    BadDay restless{faults};
    restless.run_for(5s);
    std::vector<ano::TimePoint> times;
    for (const Arrived& a : restless.arrived) times.push_back(a.at);
    EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
    EXPECT_GE(times.front(), start + 100ms);
    BadDay calm{{}};
    calm.run_for(5s);
    std::size_t elsewhere = 0;
    for (std::size_t i = 0; i < restless.arrived.size(); ++i) elsewhere += restless.arrived[i].bytes != calm.arrived[i].bytes;
    EXPECT_GT(elsewhere, restless.arrived.size() / 2);
}

TEST(FaultyLine, receives_nothing_after_the_configured_time_and_continues_sending) {
    Faults faults;
    faults.deaf_after = 2s;
    BadDay day{faults};
    day.run_for(1s);
    day.ask_who_it_is();
    EXPECT_EQ(day.count(0xE3), 1u);
    day.run_for(1s);
    day.ask_who_it_is();
    EXPECT_EQ(day.count(0xE3), 1u);
    EXPECT_EQ(day.line.counters().unheard, 1u);
    day.arrived.clear();
    day.run_for(1s);
    EXPECT_GT(day.count(0x03), 40u);
}

TEST(FaultyLine, drops_frames_beyond_its_capacity) {
    Faults faults;
    faults.delay = 10s;
    BadDay day{faults};
    for (std::size_t i = 0; i < FaultyLine::max_passing + 5; ++i) day.ask_who_it_is();
    EXPECT_EQ(day.line.counters().lost, 5u);
}

TEST(FaultyLine, handles_frames_slowly_and_at_most_twenty_wait) {
    Faults faults;
    faults.slow = 100ms;
    BadDay day{faults};
    for (int i = 0; i < 30; ++i) day.ask_who_it_is();
    EXPECT_EQ(day.line.counters().unheard, 10u);
    day.run_for(1s);
    EXPECT_EQ(day.count(0xE3), 10u);
    day.run_for(10s);
    EXPECT_EQ(day.count(0xE3), 20u);
    day.ask_who_it_is();
    day.run_for(100ms);
    EXPECT_EQ(day.count(0xE3), 21u) << "it is idle again";
}

// Like a device that loses power: values that were not stored are lost.
TEST(FaultyLine, a_device_that_restarts_is_silent_for_a_second_and_restores_its_stored_values) {
    BadDay day{{.restart_after = 5s}};
    auto& parameters = day.line.device().device().parameters();
    const auto act = [&](std::uint8_t action) {
        const Bytes question = frame(0xFE, 0xDD, 0xE0, {0x10, action, 0});
        day.line.take(ano::FrameView{question}, day.now, day.receive);
    };
    const auto value = [&](const char* name) { return parameters[*parameters.find(name)].get(); };
    ASSERT_TRUE(parameters.write("CAL_AOFF_X", 12.0) && parameters.write("SIM_BAR_OFFSET", std::int64_t{7}));
    act(0x21);
    ASSERT_TRUE(parameters.write("SIM_BAR_OFFSET", std::int64_t{8}));
    act(0x20);
    day.run_for(4900ms);
    EXPECT_EQ(value("CAL_AOFF_X"), ano::device::Value{0.0});
    const std::size_t before = day.count(0x01);
    day.run_for(200ms);
    EXPECT_EQ(value("CAL_AOFF_X"), ano::device::Value{12.0});
    EXPECT_EQ(value("SIM_BAR_OFFSET"), ano::device::Value{std::int64_t{7}});
    day.run_for(800ms);
    EXPECT_LE(day.count(0x01) - before, 6u);
    act(0x20);
    EXPECT_EQ(value("CAL_AOFF_X"), ano::device::Value{12.0}) << "it is still restarting";
    day.run_for(1s);
    EXPECT_GT(day.count(0x01) - before, 40u);
    act(0x20);
    day.run_for(10s);
    EXPECT_EQ(value("CAL_AOFF_X"), ano::device::Value{0.0}) << "it restarts once";
}

TEST(FaultyLine, with_the_vendor_parser_a_damaged_LEN_makes_the_device_deaf_until_its_bytes_arrive) {
    Faults faults;
    faults.vendor_parser = true;
    BadDay day{faults};
    day.ask_who_it_is();
    EXPECT_EQ(day.count(0xE3), 1u);
    const Bytes header{0xAB, 0xFE, 0xDC, 0xE0, 190, 0};
    day.line.take(header, day.now, day.receive);
    for (int i = 0; i < 17; ++i) day.ask_who_it_is();
    EXPECT_EQ(day.count(0xE3), 1u);
    day.line.take(Bytes(206), day.now, day.receive);
    day.ask_who_it_is();
    EXPECT_EQ(day.count(0xE3), 2u);
}

TEST(FaultyLine, with_one_at_a_time_frames_are_lost_while_it_is_busy) {
    Faults faults;
    faults.slow = 10ms;
    faults.one_at_a_time = true;
    BadDay day{faults};
    for (int i = 0; i < 8; ++i) day.ask_who_it_is();
    EXPECT_EQ(day.line.counters().unheard, 7u);
    day.run_for(10ms);
    EXPECT_EQ(day.count(0xE3), 1u);
    day.ask_who_it_is();
    day.run_for(10ms);
    EXPECT_EQ(day.count(0xE3), 2u);
}

}    // namespace
}    // namespace faulty_line_tests
