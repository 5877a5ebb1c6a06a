// The simulated devices that do not fly, as arithmetic.
#include <world/car.hpp>
#include <world/flow_sensor.hpp>
#include <world/imu.hpp>
#include <world/kinds.hpp>
#include <world/radio.hpp>
#include <world/room.hpp>

#include <support/simulated.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace other_devices_tests {
namespace {

using namespace ano::world;
using namespace std::chrono_literals;
using support::Bytes;
using support::Simulated;

struct Kind {
    std::string_view kind;
    std::uint8_t id;
    std::string_view name;
};
constexpr Kind all_kinds[]{{"fc", 0xDC, "SimFC"},
                           {"imu", 0xDD, "SimIMU"},
                           {"flow", 0xDE, "SimFlow"},
                           {"radio", 0xE6, "SimRadio"},
                           {"car", 40, "SimCar"}};

TEST(SimulatedKinds, report_their_device_info_at_the_default_address_or_another) {
    for (const Kind& kind : all_kinds)
        for (const std::uint8_t id : {std::uint8_t{0}, std::uint8_t{77}}) {
            const auto device = make_device(kind.kind, {id, 50, 1}, ano::TimePoint{1000s});
            EXPECT_EQ(device->device().info().id, id == 0 ? kind.id : id);
            EXPECT_EQ(device->device().info().name, kind.name);
            EXPECT_GE(device->device().parameters().count(), 2u) << kind.name;
        }
}

// Info, erase, the only frame, all sent.
TEST(SimulatedKinds, accept_a_firmware_image_on_the_ground) {
    Simulated<Imu> imu;
    const Bytes image{1, 2, 3, 4};
    const std::uint16_t crc = ano::crc16_of(image);
    const auto low = static_cast<std::uint8_t>(crc), high = static_cast<std::uint8_t>(crc >> 8);
    const auto code = [&](const Bytes& f) { return f[7] | f[8] << 8; };
    const auto last_code = [&] {
        for (auto f = imu.said.rbegin(); f != imu.said.rend(); ++f)
            if ((*f)[3] == 0xF0) return code(*f);
        return 0;
    };
    imu.answers(0xF0, {1, 4, 0, 0, 0, 195, 0, low, high, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(last_code(), 0x0102);
    imu.answers(0xF0, {0, 0x10, 0x01});
    imu.run_for(2s);
    EXPECT_EQ(last_code(), 0x0112) << "erased, after a while";
    imu.answers(0xF0, {0x10, 0, 0, 1, 2, 3, 4});
    EXPECT_EQ(last_code(), 0x1002);
    imu.answers(0xF0, {0, 0x10, 0x10});
    imu.run_for(1s);
    EXPECT_EQ(last_code(), 0x1012);
}

TEST(SimulatedImu, sways_as_configured) {
    Simulated<Imu> imu;
    double most = 0;
    for (int i = 0; i < 20; ++i) most = std::max(most, std::abs(imu.next<"euler">()->get<"rol">()));
    EXPECT_NEAR(most, 5, 0.5);
    ASSERT_TRUE(imu.write("SIM_SWAY", 0.0f));
    EXPECT_LT(std::abs(imu.next<"euler">()->get<"rol">()), 0.3);
    EXPECT_NEAR(imu.next<"inertial">()->get<"acc_z">(), 981, 60);
    EXPECT_EQ(imu.next<"quaternion">()->get<"v0">(), 1);
    EXPECT_TRUE(imu.next<"compass">());
    EXPECT_TRUE(imu.next<"altitude">());
}

TEST(SimulatedFlow, measures_how_it_is_moved) {
    Simulated<FlowSensor> flow;
    ASSERT_TRUE(flow.write("SIM_SPEED", std::uint16_t{100}));
    const auto fused = *flow.next<"optical_flow", "mode1">();
    EXPECT_NEAR(std::hypot(fused.get<"dx_1">(), fused.get<"dy_1">()), 100, 12);
    EXPECT_EQ(fused.get<"state">(), 1);
    EXPECT_EQ(fused.get<"quality">(), 255);
    const auto raw = *flow.next<"optical_flow">();
    EXPECT_NEAR(std::hypot(raw.get<"dx_0">(), raw.get<"dy_0">()), 8, 2) << "pixels in 20 ms";
    const auto whole = *flow.next<"optical_flow", "mode2">();
    EXPECT_NEAR(std::hypot(whole.get<"dx_fix">(), whole.get<"dy_fix">()), 100, 2);
    EXPECT_NEAR(flow.next<"ranging">()->get<"dist">(), 1000, 30) << "mm";
    ASSERT_TRUE(flow.write("SIM_HEIGHT", std::uint16_t{1000}));
    EXPECT_EQ((flow.next<"optical_flow", "mode1">()->get<"state">()), 0) << "too high to see anything";
}

TEST(SimulatedRadio, reports_its_link_quality) {
    Simulated<Radio> radio;
    const auto figures = [&] {
        radio.said.clear();
        radio.run_for(1s);
        for (const Bytes& f : radio.said)
            if (f[3] == 0xFA) return f;
        return Bytes(16);
    };
    const Bytes near = figures();
    EXPECT_NEAR(static_cast<std::int8_t>(near[6]), 20 - 40 - 46, 25) << "dBm";
    EXPECT_NEAR(static_cast<std::int8_t>(near[7]), -100, 5);
    EXPECT_EQ(near[8], 0) << "% lost";
    ASSERT_TRUE(radio.write("SIM_DISTANCE", std::uint32_t{100'000}));
    const Bytes far = figures();
    EXPECT_LT(static_cast<std::int8_t>(far[6]), static_cast<std::int8_t>(near[6]) - 20);
    EXPECT_GT(far[8], 50);
    EXPECT_EQ(radio.count(0xA1), 1u) << "it says so once";
}

struct DrivenCar : Simulated<Car> {
    DrivenCar() { EXPECT_TRUE(does(0xC0, {0x20, 0, 1})) << "unlocked"; }
    bool go_to(std::int32_t x, std::int32_t y) {
        Bytes data{0x20, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0};
        ano::store(data.data() + 3, x);
        ano::store(data.data() + 7, y);
        return does(0xC0, data);
    }
    // Sends 0x41 for a while.
    void steer(ano::Duration time, int speed, int turn) {
        ano::Draft<"realtime_control"> control;
        ASSERT_TRUE(control.set<"ctrl_spd_x">(speed) && control.set<"ctrl_yaw_dps">(turn));
        keep(time, control);
    }
    void stick(ano::Duration time, int pit, int rol) {
        ano::Draft<"remote_control"> sticks;
        ASSERT_TRUE(sticks.set<"pit">(pit) && sticks.set<"rol">(rol) && sticks.set<"thr">(1500) && sticks.set<"yaw">(1500));
        keep(time, sticks);
    }
    template <class Draft>
    void keep(ano::Duration time, const Draft& draft) {
        Bytes bytes(64);
        bytes.resize(draft.encode(bytes, 0xFE, 40));
        for (const auto end = now + time; now < end; run_for(100ms)) device.take(ano::FrameView{bytes}, now, receive);
    }
};

TEST(SimulatedCar, drives_to_the_commanded_position) {
    DrivenCar car;
    ASSERT_TRUE(car.go_to(500, 1000));
    ASSERT_TRUE(car.run_until([&] { return (car.device.position() - Vector{5, 10, 0}).length() < 0.2; }));
    car.run_for(2s);
    EXPECT_LT(car.device.speed(), 0.1);
    EXPECT_NEAR(car.next<"position">()->get<"pos_y">(), 1000, 20);
    EXPECT_FALSE(car.go_to(5000, 0)) << "behind the wall";
    EXPECT_TRUE(car.does(0xC0, {0x20, 0, 2}));
    EXPECT_FALSE(car.go_to(0, 0)) << "locked";
    EXPECT_EQ(car.next<"mode">()->get<"sflag">(), 0);
}

TEST(SimulatedCar, follows_steering_and_stops_without_it) {
    DrivenCar car;
    car.steer(3s, 200, 0);
    EXPECT_NEAR(car.device.speed(), 2, 0.05);
    EXPECT_NEAR(car.next<"velocity">()->get<"speed_x">(), 100, 100);
    car.run_for(3s);
    EXPECT_EQ(car.device.speed(), 0);
    car.steer(1s, 0, 45);
    EXPECT_NEAR(car.device.yaw() / degree, 45, 6);
    car.stick(2s, 2000, 1500);
    EXPECT_NEAR(car.device.speed(), 3, 0.1) << "full speed";
    car.stick(1s, 1500, 2000);
    EXPECT_LT(car.device.yaw() / degree, 0) << "to the right";
    car.stick(100ms, 0, 0);
    car.run_for(2s);
    EXPECT_EQ(car.device.speed(), 0) << "no link";
}

TEST(SimulatedCar, stays_between_its_walls) {
    DrivenCar car;
    car.steer(30s, 300, 0);
    EXPECT_NEAR(car.device.position().x, wall_ahead - 0.2, 0.01);
    EXPECT_NEAR(car.next<"ranging">()->get<"dist">(), 200, 2) << "mm ahead";
}

}    // namespace
}    // namespace other_devices_tests
