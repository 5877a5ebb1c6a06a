// sim:lx, in the previous protocol version.
#include <world/lx_unit.hpp>

#include <ano/wire.hpp>
#include <support/bytes.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace lx_unit_tests {
namespace {

using namespace ano::world;
using namespace std::chrono_literals;
using support::Bytes;
using support::v7_frame;
namespace v7 = ano::v7;

using Frames = std::vector<Bytes>;
constexpr std::uint8_t imu = 0x60, everybody = 0xFF, host = 0xAF;

struct Line {
    void run_for(ano::Duration time) {
        for (const auto end = now + time; now < end;) {
            now = std::min(end, device.due());
            device.run(now, receive);
        }
    }
    /// Its answers to this frame.
    Frames answers(const Bytes& frame) {
        said.clear();
        device.receive(frame, now, receive);
        return said;
    }
    Frames command(const Bytes& bytes) {
        Bytes data = bytes;
        data.resize(11);
        return answers(v7_frame(everybody, 0xE0, data));
    }
    std::int32_t read(std::uint16_t number) {
        const Frames got = answers(v7_frame(imu, 0xE1, two(number)));
        EXPECT_EQ(got.size(), 1u);
        return got.empty() ? 0 : ano::load<std::int32_t>(got[0].data() + v7::header_size + 2);
    }
    Bytes write(std::uint16_t number, std::int32_t value) {
        Bytes data = two(number);
        data.resize(6);
        ano::store(data.data() + 2, value);
        Bytes frame = v7_frame(imu, 0xE2, data);
        EXPECT_EQ(answers(frame), Frames{acknowledged(frame)});
        return frame;
    }
    static Bytes two(std::uint16_t number) { return {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8)}; }
    static Bytes acknowledged(const Bytes& frame) {
        return v7_frame(host, 0x00, {frame[2], frame[frame.size() - 2], frame.back()});
    }
    std::map<std::uint8_t, std::size_t> counts() const {
        std::map<std::uint8_t, std::size_t> all;
        for (const Bytes& frame : said) ++all[frame[2]];
        return all;
    }
    Bytes next(std::uint8_t id) {
        said.clear();
        run_for(1s);
        for (auto frame = said.rbegin(); frame != said.rend(); ++frame)
            if ((*frame)[2] == id) return {frame->begin() + v7::header_size, frame->end() - 2};
        return {};
    }

    ano::TimePoint now{1000s};
    Frames said;
    const SimulatedDevice::Send receive = [this](ano::Bytes frame, ano::TimePoint) {
        said.emplace_back(frame.begin(), frame.end());
    };
    LxUnit device{{0, 50, 1}, now};
};

TEST(SimulatedLx, sends_the_messages_that_were_captured_at_their_rates) {
    Line line;
    line.run_for(30s);
    const std::map<std::uint8_t, double> hz{{0x01, 50}, {0x02, 20}, {0x03, 40}, {0x04, 40},   {0x05, 20},   {0x06, 3.33},
                                            {0x07, 20}, {0x08, 10}, {0x09, 10}, {0x0D, 3.33}, {0x0E, 3.33}, {0x20, 50},
                                            {0x30, 5},  {0x40, 5},  {0x41, 10}, {0xFA, 383}};
    const auto counts = line.counts();
    ASSERT_EQ(counts.size(), hz.size());
    for (const auto& [id, rate] : hz) EXPECT_NEAR(static_cast<double>(counts.at(id)), 30 * rate, 2) << int{id};
    std::size_t bytes = 0;
    std::map<std::uint8_t, std::size_t> size_of;
    for (const Bytes& frame : line.said) {
        ASSERT_TRUE(v7::frame_at(frame));
        EXPECT_EQ(frame[1], host);
        bytes += frame.size();
        size_of[frame[2]] = frame.size();
    }
    EXPECT_NEAR(static_cast<double>(bytes) / 30, 7600, 1500) << "bytes per second";
    std::size_t compared = 0;
    for (const auto& vector : support::v7_vectors("valid")) {
        if (!size_of.contains(vector.v7[2]) || vector.v7[1] != host) continue;
        EXPECT_EQ(size_of[vector.v7[2]], vector.v7.size()) << vector.meaning;
        ++compared;
    }
    EXPECT_GE(compared, 8u);
}

TEST(SimulatedLx, measures_at_rest_as_the_captured_one) {
    Line line;
    EXPECT_NEAR(ano::load<std::int16_t>(line.next(0x01).data() + 4), 1365, 90) << "1 g up";
    EXPECT_NEAR(ano::load<std::int16_t>(line.next(0x02).data() + 10), 4400, 100) << "°C x 100";
    const Bytes mode = line.next(0x06);
    EXPECT_EQ(mode, (Bytes{2, 0, 0, 0, 0}));
    line.command({0x10, 0, 1});
    EXPECT_EQ(line.next(0x06)[1], 1) << "unlocked";
}

TEST(SimulatedLx, acknowledges_commands_and_writes_also_unknown_ones) {
    Line line;
    for (const Bytes& command : {Bytes{0x01, 0, 2}, Bytes{0x77, 1, 2}}) {
        Bytes data = command;
        data.resize(11);
        const Frames got = line.command(command);
        EXPECT_EQ(std::count(got.begin(), got.end(), Line::acknowledged(v7_frame(everybody, 0xE0, data))), 1);
    }
    line.write(9999, 5);
    EXPECT_EQ(line.read(9999), INT32_MIN) << "no such parameter";
    EXPECT_EQ(line.answers(v7_frame(0x05, 0xE1, {1, 0})), Frames{}) << "for another device";
    EXPECT_EQ(line.answers(v7_frame(everybody, 0xE0, {0x10, 0, 1})), Frames{}) << "not 11 bytes";
}

TEST(SimulatedLx, stores_a_parameter_three_seconds_after_it_was_written) {
    Line line;
    EXPECT_EQ(line.read(1), imu);
    line.write(151, 42);
    line.run_for(2s);
    line.device.restart();
    EXPECT_EQ(line.read(151), 0);
    line.write(151, 42);
    line.run_for(4s);
    line.device.restart();
    EXPECT_EQ(line.read(151), 42);
    line.write(1, 7);
    EXPECT_EQ(line.read(1), imu) << "its type can't be written";
}

TEST(SimulatedLx, changes_and_stops_a_message_by_its_period) {
    Line line;
    line.write(302, 100);
    line.write(303, 0);
    line.run_for(100ms);
    line.said.clear();
    line.run_for(2s);
    EXPECT_NEAR(static_cast<double>(line.counts()[0x03]), 20, 1);
    EXPECT_EQ(line.counts()[0x04], 0u);
}

TEST(SimulatedLx, flies_in_the_modes_of_each_command_and_stops_at_once) {
    Line line;
    line.command({0x01, 1, 1, 0});
    line.command({0x10, 0, 5, 150, 0});
    line.run_for(5s);
    EXPECT_EQ(line.device.flight().safety(), Flight::Safety::locked) << "no take-off in mode 0";
    line.command({0x01, 1, 1, 3});
    line.command({0x10, 0, 5, 150, 0});
    EXPECT_EQ(line.next(0x06), (Bytes{3, 1, 0x10, 0, 5}));
    line.run_for(8s);
    EXPECT_NEAR(line.device.flight().body().position().z, 1.5, 0.2);
    line.command({0x10, 2, 3, 200, 0, 100, 0, 0, 0});
    line.run_for(8s);
    EXPECT_NEAR(line.device.flight().body().position().x, 2, 0.4);
    line.command({0x10, 0, 2});
    line.run_for(200ms);
    EXPECT_EQ(line.device.flight().safety(), Flight::Safety::locked);
    EXPECT_LT(line.device.flight().body().velocity().z, -1) << "it falls";
}

TEST(SimulatedLx, counts_frames_that_it_takes_for_its_own_measurements) {
    Line line;
    EXPECT_EQ(line.answers(v7_frame(everybody, 0x03, {1, 0, 2, 0, 3, 0, 1})), Frames{});
    EXPECT_EQ(line.device.false_measurements(), 1u);
    EXPECT_FALSE(line.device.is_erased());
    line.command({0x01, 0x20, 0xAA, 1});
    EXPECT_TRUE(line.device.is_erased());
    line.said.clear();
    line.run_for(1s);
    EXPECT_EQ(line.said, Frames{});
}

TEST(SimulatedLx, keeps_waypoints) {
    Line line;
    EXPECT_EQ(line.answers(v7_frame(everybody, 0x60, {0xFF})), Frames{v7_frame(host, 0x60, {0})});
    Bytes point(22, 3);
    point[0] = 0;
    const Bytes written = v7_frame(everybody, 0x61, point);
    EXPECT_EQ(line.answers(written), Frames{Line::acknowledged(written)});
    EXPECT_EQ(line.answers(v7_frame(everybody, 0x60, {0})), Frames{v7_frame(host, 0x61, point)});
    EXPECT_EQ(line.answers(v7_frame(everybody, 0x60, {1})), Frames{});
    line.command({0x01, 0, 0x62});
    EXPECT_EQ(line.answers(v7_frame(everybody, 0x60, {0xFF})), Frames{v7_frame(host, 0x60, {0})});
}

}    // namespace
}    // namespace lx_unit_tests
