// A host calibrates the simulated devices: the result corrects their measurements.
#include <host/calibration.hpp>
#include <world/car.hpp>
#include <world/faulty_line.hpp>
#include <world/flight_controller.hpp>
#include <world/imu.hpp>
#include <world/kinds.hpp>

#include <support/simulated.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace calibration_tests {
namespace {

using namespace std::chrono_literals;
using ano::host::Calibration;
using ano::host::Sensor;
using support::Bytes;

template <class Device>
struct Workshop {
    explicit Workshop(std::uint64_t seed) : bench{ano::world::Settings{0, 50, seed}}, host{bench.device.device().info().id} {
        bench.write("SIM_SWAY", 0.0f);    // for the device that has it
    }

    // The simulated hand releases it some seconds after the values were stored.
    void wait_until_let_go() { bench.run_for(60s); }
    // Runs the host and the device on a line without faults, until the task ends.
    void drive(Calibration& task) {
        task.start(bench.now);
        for (const auto end = bench.now + 10min; !task.end() && bench.now < end;) {
            if (task.step() == Calibration::Step::keep) task.kept(bench.now);
            while (const auto asked = host.next_frame(bench.now)) {
                const Bytes question(asked->bytes().begin(), asked->bytes().end());
                bench.device.take(ano::FrameView{question}, bench.now, bench.receive);
            }
            bench.run_for(10ms);
            for (const Bytes& said : std::exchange(bench.said, {})) {
                host.take(ano::FrameView{said}, bench.now);
                task.receive(ano::FrameView{said}, bench.now);
            }
            task.look(bench.now);
        }
    }
    void calibrate(Sensor sensor) {
        Calibration task{host, sensor};
        drive(task);
        ASSERT_TRUE(task.end());
        ASSERT_EQ(task.end()->ending, ano::host::Ending::done) << task.end()->fault.text();
        ASSERT_LT(task.residuals()->second, task.residuals()->first / 3);
    }
    std::vector<ano::world::Vector> measured(std::uint8_t id) {
        std::vector<ano::world::Vector> all;
        bench.said.clear();
        bench.run_for(40s);
        for (const Bytes& said : bench.said) {
            if (said[3] != id) continue;
            const auto axis = [&](std::size_t n) {
                return static_cast<double>(ano::load<std::int16_t>(said.data() + 6 + 2 * n));
            };
            all.push_back({axis(0), axis(1), axis(2)});
        }
        return all;
    }

    support::Simulated<Device> bench;
    ano::host::Device host;
};

template <class Device>
void straightens_the_accelerometer() {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        Workshop<Device> shop{seed};
        const auto error = [&] {
            ano::world::Vector sum;
            const auto all = shop.measured(0x01);
            for (const auto& a : all) sum = sum + (1.0 / static_cast<double>(all.size())) * a;
            return (sum - ano::world::Vector{0, 0, 980.665}).length();
        };
        const double before = error();
        EXPECT_GT(before, 5) << "seed " << seed;
        ASSERT_NO_FATAL_FAILURE(shop.calibrate(Sensor::accelerometer));
        shop.wait_until_let_go();
        EXPECT_LT(error(), 2) << "seed " << seed << ", before " << before;
    }
}

template <class Device>
void rounds_the_compass() {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        Workshop<Device> shop{seed};
        ASSERT_NO_FATAL_FAILURE(shop.calibrate(Sensor::compass));
        const auto all = shop.measured(0x02);
        ASSERT_FALSE(all.empty());
        const double strength = all.front().length();
        for (const auto& m : all) ASSERT_NEAR(m.length(), strength, 0.05 * strength);
        EXPECT_NEAR(strength, 500, 50);
    }
}

// On a line, as `sim:imu,restart_after=15s`: its old calibration becomes active again halfway.
TEST(CalibrationOfSimulated, corrects_the_accelerometer_of_an_imu_that_restarts_meanwhile) {
    const ano::TimePoint start{1000s};
    ano::world::FaultyLine line{ano::world::make_device("imu", {0, 50, 1}, start), {.restart_after = 15s}, 1, start};
    auto& parameters = line.device().device().parameters();
    ASSERT_TRUE(parameters.write("CAL_AOFF_X", 60.0) && parameters.write("CAL_ASEN_Y", 1.05));
    ano::TimePoint now = start;
    ano::host::Device host{0xDD};
    Calibration task{host, Sensor::accelerometer};
    std::vector<Bytes> said;
    const auto receive = [&](ano::Bytes bytes, ano::TimePoint) { said.emplace_back(bytes.begin(), bytes.end()); };
    const Bytes store = support::frame(0xFE, 0xDD, 0xE0, {0x10, 0xAB, 0});
    line.take(ano::FrameView{store}, now, receive);
    task.start(now);
    while (!task.end() && now < start + 5min) {
        now += 10ms;
        if (task.step() == Calibration::Step::keep) task.kept(now);
        while (const auto asked = host.next_frame(now)) line.take(*asked, now, receive);
        line.run(now, receive);
        for (const Bytes& one : std::exchange(said, {})) {
            host.take(ano::FrameView{one}, now);
            task.receive(ano::FrameView{one}, now);
        }
        task.look(now);
    }
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, ano::host::Ending::done) << task.end()->fault.text();
    EXPECT_EQ(task.restarts(), 1u);
    EXPECT_EQ(task.last_restart().text(), "no samples for 1.0 s");
    EXPECT_LT(task.verified().value_or(100), 3);
}

TEST(CalibrationOfSimulated, corrects_the_accelerometer_of_the_flight_controller) {
    straightens_the_accelerometer<ano::world::FlightController>();
}
TEST(CalibrationOfSimulated, corrects_the_accelerometer_of_the_imu) { straightens_the_accelerometer<ano::world::Imu>(); }
TEST(CalibrationOfSimulated, corrects_the_accelerometer_of_the_car) { straightens_the_accelerometer<ano::world::Car>(); }
TEST(CalibrationOfSimulated, corrects_the_compass_of_the_flight_controller) {
    rounds_the_compass<ano::world::FlightController>();
}

}    // namespace
}    // namespace calibration_tests
