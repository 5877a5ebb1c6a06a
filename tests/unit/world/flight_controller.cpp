// The flight of the simulated flight controller, as arithmetic.
#include <world/flight_controller.hpp>

#include <support/simulated.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace flight_controller_tests {
namespace {

using namespace ano::world;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;

struct FlyingFc : support::Simulated<FlightController> {
    using Simulated::Simulated;

    const Flight& flight() const { return device.flight(); }
    Vector place() const { return flight().body().position(); }
    bool is_at(Vector there, double within = 0.3) const { return (place() - there).length() < within; }
    void fly_to(double height) {
        ASSERT_TRUE(command(1, static_cast<std::uint16_t>(height * 100)));
        ASSERT_TRUE(run_until([&] { return flight().task() == Flight::Task::hover; }));
    }
    bool has_sent_text(std::string_view text) const {
        for (const Bytes& f : said)
            if (const auto line = ano::as<"log">(ano::FrameView{f}); line && line->get<"str">() == text) return true;
        return false;
    }
    void stick(std::int16_t rol, std::int16_t pit, std::int16_t thr, std::int16_t yaw) {
        ano::Draft<"remote_control"> sticks;
        ASSERT_TRUE(sticks.set<"rol">(rol) && sticks.set<"pit">(pit) && sticks.set<"thr">(thr) && sticks.set<"yaw">(yaw));
        receive_draft(sticks);
    }
    template <class Draft>
    void receive_draft(const Draft& draft) {
        Bytes bytes(64);
        bytes.resize(draft.encode(bytes, 0xFE, 0xDC));
        device.take(ano::FrameView{bytes}, now, receive);
    }
    void keep_steering(ano::Duration time, const std::function<void()>& steer) {
        for (const auto end = now + time; now < end; run_for(50ms)) steer();
    }
};

TEST(FlightController, reports_its_device_info) {
    FlyingFc fc;
    const Bytes expected = frame(0xDC, 0xFE, 0xE3, support::hex("DC 64 00 64 00 00 00 20 03 53 69 6D 46 43"));
    EXPECT_EQ(fc.answers(0xE0, {0, 0, 0}), (std::vector<Bytes>{expected}));
}

TEST(FlightController, has_150_parameters_of_all_types) {
    FlyingFc fc;
    EXPECT_EQ(fc.answers(0xE0, {1, 0, 0}), (std::vector<Bytes>{frame(0xDC, 0xFE, 0xE0, {1, 150, 0})}));
    std::set<int> types;
    for (std::uint8_t id = 0; id < 150; ++id) {
        const auto described = fc.answers(0xE0, {3, id, 0});
        ASSERT_EQ(described.size(), 1u);
        types.insert(ano::as<"parameter_info">(ano::FrameView{described.front()})->get<"par_type">());
        EXPECT_EQ(fc.answers(0xE0, {2, id, 0}).size(), 1u);
    }
    EXPECT_EQ(types.size(), 11u);
    EXPECT_FALSE(fc.write("SIM_SERIAL", std::uint64_t{5}));
    EXPECT_TRUE(fc.does(0xE0, {0x10, 0xAB, 0})) << "saved";
}

TEST(FlightController, has_12_commands_with_values_of_all_types) {
    FlyingFc fc;
    EXPECT_EQ(fc.answers(0xC1, {0, 0, 0}), (std::vector<Bytes>{frame(0xDC, 0xFE, 0xC1, {0, 12, 0})}));
    std::set<int> types;
    for (std::uint8_t id = 0; id < 12; ++id) {
        const auto described = fc.answers(0xC1, {1, id, 0});
        ASSERT_EQ(described.size(), 1u);
        for (const int type : ano::as<"command_info">(ano::FrameView{described.front()})->get<"val_type">()) types.insert(type);
    }
    EXPECT_EQ(types, (std::set<int>{0, 1, 2, 3, 4, 5, 6, 8, 9, 10}));
    EXPECT_TRUE(fc.command(5, std::uint8_t{1}, std::int8_t{-1}, std::uint16_t{2}, std::int16_t{3}, 4u, 5, 2.0f, 1.0));
    EXPECT_EQ(ano::as<"log_value">(ano::FrameView{fc.said.front()})->get<"val">(), 17);
}

TEST(FlightController, stays_on_the_ground_until_commanded_to_take_off) {
    FlyingFc fc;
    fc.run_for(5s);
    EXPECT_EQ(fc.place(), Vector{});
    EXPECT_EQ(fc.next<"mode">()->get<"sflag">(), 0);
    EXPECT_EQ(fc.next<"altitude">()->get<"alt_fu">(), 0);
    for (const int number : {4, 8, 9, 10, 12})
        EXPECT_FALSE(fc.command(static_cast<std::uint8_t>(number), std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{0}));
    EXPECT_TRUE(fc.command(6)) << "unlocked";
    EXPECT_EQ(fc.next<"mode">()->get<"sflag">(), 1);
    EXPECT_EQ(fc.place(), Vector{});
    EXPECT_TRUE(fc.command(7));
    EXPECT_EQ(fc.next<"mode">()->get<"sflag">(), 0);
}

TEST(FlightController, takes_off_hovers_and_lands) {
    FlyingFc fc;
    EXPECT_FALSE(fc.command(1, std::uint16_t{1})) << "1 cm is no height";
    fc.fly_to(3);
    EXPECT_TRUE(fc.has_sent_text("done"));
    double most = 0;
    for (int i = 0; i < 100; ++i) {
        fc.run_for(100ms);
        most = std::max(most, (fc.place() - Vector{0, 0, 3}).length());
    }
    EXPECT_LT(most, 0.5) << "in the wind";
    EXPECT_NEAR(fc.next<"altitude">()->get<"alt_fu">(), 300, 20);
    EXPECT_EQ(fc.next<"mode">()->get<"sflag">(), 2);
    EXPECT_FALSE(fc.command(7)) << "locked in the air it would fall";
    EXPECT_NEAR(fc.next<"power">()->get<"voltage">(), 12.2, 0.3);
    ASSERT_TRUE(fc.command(2));
    EXPECT_EQ(fc.next<"mode">()->get<"cmd1">(), 2);
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().safety() == Flight::Safety::locked; }));
    EXPECT_TRUE(fc.has_sent_text("landed"));
    EXPECT_EQ(fc.place().z, 0);
    EXPECT_EQ(fc.next<"velocity">()->get<"speed_x">(), 0);
    EXPECT_EQ(fc.next<"mode">()->get<"cmd1">(), 4) << "back to hover";
}

TEST(FlightController, flies_to_a_position_turns_and_returns_home) {
    FlyingFc fc;
    fc.fly_to(2);
    ASSERT_TRUE(fc.command(8, std::int64_t{1000}, std::int64_t{-500}, std::uint16_t{400}));
    EXPECT_EQ(fc.next<"mode">()->get<"cmd1">(), 8);
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().task() == Flight::Task::hover; }));
    fc.run_for(3s);
    EXPECT_TRUE(fc.is_at({10, -5, 4})) << fc.place().x << ' ' << fc.place().y << ' ' << fc.place().z;
    EXPECT_NEAR(fc.next<"position">()->get<"pos_x">(), 1000, 30);
    EXPECT_NEAR(fc.next<"return_home">()->get<"r_d">(), 11, 1);
    ASSERT_TRUE(fc.command(9, std::int16_t{-90}));
    fc.run_for(5s);
    EXPECT_NEAR(fc.next<"euler">()->get<"yaw">(), -90, 3);
    EXPECT_FALSE(fc.command(8, std::int64_t{1'000'000}, std::int64_t{0}, std::uint16_t{400})) << "too far";
    ASSERT_TRUE(fc.command(10));
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().safety() == Flight::Safety::locked; }));
    EXPECT_TRUE(fc.is_at({0, 0, 0}));
}

struct Looks {
    int yaw = 400, fun = 0, seconds = 0;
};

void put(FlyingFc& fc, std::uint8_t num, double lng, double lat, int alt, Looks looks = {}) {
    ano::Draft<"waypoint"> w;
    EXPECT_TRUE(w.set<"num">(num) && w.set<"lng">(lng) && w.set<"lat">(lat) && w.set<"alt">(alt) && w.set<"spd">(500));
    EXPECT_TRUE(w.set<"yaw">(looks.yaw) && w.set<"fun">(looks.fun) && w.set<"cmd1">(looks.seconds));
    Bytes bytes(64);
    bytes.resize(w.encode(bytes, 0xFE, 0xDC));
    EXPECT_TRUE(fc.does(0x61, Bytes(bytes.begin() + 6, bytes.end() - 2)));
}

TEST(FlightController, flies_its_waypoints) {
    FlyingFc fc;
    EXPECT_EQ(fc.answers(0x60, {0xFF}), (std::vector<Bytes>{frame(0xDC, 0xFE, 0x60, {1})}));
    put(fc, 1, 116.3, 39.9001, 500);       // 11 m to the north
    put(fc, 2, 116.2999, 39.9001, 500);    // 8.5 m to the west
    fc.fly_to(2);
    EXPECT_FALSE(fc.command(12, std::uint8_t{3})) << "there is none";
    ASSERT_TRUE(fc.command(12, std::uint8_t{1}));
    ASSERT_TRUE(fc.run_until([&] { return fc.is_at({11.13, 0, 5}); }));
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().task() == Flight::Task::hover; }));
    EXPECT_TRUE(fc.is_at({11.13, 8.54, 5})) << fc.place().x << ' ' << fc.place().y << ' ' << fc.place().z;
}

TEST(FlightController, faces_the_next_waypoint_or_the_yaw_that_the_waypoint_sets) {
    FlyingFc fc;
    put(fc, 1, 116.2999, 39.9, 200);                 // 8.5 m to the west
    put(fc, 2, 116.2998, 39.9, 200, {.yaw = 90});    // further on, looking back to the east
    fc.fly_to(2);
    ASSERT_TRUE(fc.command(12, std::uint8_t{1}));
    const auto yaw = [&] { return fc.flight().body().angles().yaw / degree; };
    ASSERT_TRUE(fc.run_until([&] { return fc.is_at({0, 7, 2}, 1); }));
    EXPECT_NEAR(yaw(), 90, 5) << "west, to the left of north";
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().task() == Flight::Task::hover; }));
    EXPECT_TRUE(fc.is_at({0, 17.1, 2}));
    EXPECT_NEAR(yaw(), -90, 3);
}

TEST(FlightController, stays_at_a_waypoint_for_the_time_that_the_waypoint_sets) {
    FlyingFc fc;
    put(fc, 1, 116.3, 39.9, 200, {.fun = 1, .seconds = 20});    // above home
    put(fc, 2, 116.3, 39.9001, 200);
    fc.fly_to(2);
    ASSERT_TRUE(fc.command(12, std::uint8_t{1}));
    fc.run_for(19s);
    EXPECT_TRUE(fc.is_at({0, 0, 2}));
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().task() == Flight::Task::hover; }));
    EXPECT_TRUE(fc.is_at({11.13, 0, 2}));
}

Vector seen_by_satellites(FlyingFc& fc) {
    const auto gps = *fc.next<"gps">();
    return from_home({gps.get<"lng">(), gps.get<"lat">()}, {116.3, 39.9}) +
           Vector{0, 0, gps.get<"alt_gps">() / 100.0 - Satellites::ground};
}

// In metres, at the time of the message.
double error_of_satellites(FlyingFc& fc) {
    const Vector seen = seen_by_satellites(fc);
    return (seen - fc.place()).length();
}

TEST(FlightController, reports_its_satellite_position_in_flight) {
    FlyingFc fc;
    put(fc, 1, 116.3, 39.9002, 800);
    fc.fly_to(2);
    ASSERT_TRUE(fc.command(12, std::uint8_t{1}));
    ASSERT_TRUE(fc.run_until([&] { return fc.place().x > 8; }));
    const auto gps = *fc.next<"gps">();
    EXPECT_EQ(gps.get<"fix_sta">(), 3);
    EXPECT_GE(gps.get<"s_num">(), 8);
    EXPECT_NEAR(gps.get<"n_spe">(), 100 * fc.flight().body().velocity().x, 40);
    EXPECT_LT(error_of_satellites(fc), 3);
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().task() == Flight::Task::hover; }));
    EXPECT_LT((seen_by_satellites(fc) - Vector{22.26, 0, 8}).length(), 3) << "where the waypoint is";
    ASSERT_TRUE(fc.command(8, std::int64_t{2200}, std::int64_t{-1000}, std::uint16_t{800}));    // to the east and down
    fc.run_for(2s);
    EXPECT_GT(fc.next<"gps">()->get<"e_spe">(), 50);
    ASSERT_TRUE(fc.run_until([&] { return fc.place().y < -8; }));
    EXPECT_LT(error_of_satellites(fc), 3);
    ASSERT_TRUE(fc.command(2));
    fc.run_for(3s);
    EXPECT_GT(fc.next<"gps">()->get<"d_spe">(), 20) << "it lands";
}

TEST(FlightController, satellite_positions_drift_around_the_true_position) {
    FlyingFc fc, same;
    double most = 0, furthest_step = 0;
    Vector sum, last = seen_by_satellites(fc);
    constexpr int times = 500;
    for (int i = 0; i < times; ++i) {
        const Vector now = seen_by_satellites(fc);
        most = std::max(most, std::hypot(now.x, now.y));
        furthest_step = std::max(furthest_step, std::hypot(now.x - last.x, now.y - last.y));
        sum = sum + now;
        last = now;
    }
    EXPECT_GT(most, 0.3);
    EXPECT_LT(most, 2.5);
    EXPECT_LT(furthest_step, 0.6) << "from one second to the next";
    EXPECT_LT(std::hypot(sum.x, sum.y) / times, 0.4) << "on average it is there";
    const auto first = same.next<"gps">()->data();
    FlyingFc again;
    EXPECT_TRUE(std::ranges::equal(again.next<"gps">()->data(), first)) << "the same seed, the same error";
    FlyingFc other{Settings{.id = 0, .hz = 50, .seed = 2}};
    EXPECT_FALSE(std::ranges::equal(other.next<"gps">()->data(), first));
}

TEST(FlightController, follows_the_sticks) {
    FlyingFc fc;
    fc.fly_to(3);
    fc.keep_steering(3s, [&] { fc.stick(1500, 1900, 1500, 1500); });
    EXPECT_GT(fc.place().x, 3) << "forward";
    fc.keep_steering(3s, [&] { fc.stick(1900, 1500, 1500, 1500); });
    EXPECT_LT(fc.place().y, -3) << "to the right";
    const double height = fc.place().z;
    fc.keep_steering(2s, [&] { fc.stick(1500, 1500, 1900, 1500); });
    EXPECT_GT(fc.place().z, height + 1);
    fc.keep_steering(2s, [&] { fc.stick(1500, 1500, 1500, 1900); });
    EXPECT_LT(fc.flight().body().angles().yaw, -0.5) << "to the right";
    const Vector left_at = fc.place();
    fc.run_for(10s);
    EXPECT_LT((fc.place() - left_at).length(), 1) << "nobody steers it: it stays";
    ASSERT_TRUE(fc.write("SIM_MODE", std::uint8_t{3}));
    fc.keep_steering(3s, [&] { fc.stick(1500, 1900, 1500, 1500); });
    EXPECT_LT((fc.place() - left_at).length(), 1) << "not in programmed flight";
}

TEST(FlightController, leans_in_the_modes_without_position) {
    FlyingFc fc;
    fc.fly_to(10);
    ASSERT_TRUE(fc.command(11, std::uint8_t{1}));
    fc.keep_steering(1s, [&] { fc.stick(1750, 1500, 1500, 1500); });
    EXPECT_NEAR(fc.flight().pilot().aimed_attitude().roll / degree, 15, 0.1);
    EXPECT_LT(fc.flight().body().velocity().y, -0.5);
    EXPECT_NEAR(fc.place().z, 10, 0.5) << "the height is held";
    ASSERT_TRUE(fc.command(11, std::uint8_t{0}));
    fc.keep_steering(1s, [&] { fc.stick(1500, 1500, 1000, 1500); });
    EXPECT_LT(fc.place().z, 9) << "without throttle it falls";
    EXPECT_FALSE(fc.command(11, std::uint8_t{4}));
}

TEST(FlightController, follows_realtime_control) {
    FlyingFc fc;
    fc.fly_to(3);
    const auto steer = [&](int forward, int yaw_rate) {
        ano::Draft<"realtime_control"> c;
        ASSERT_TRUE(c.set<"ctrl_spd_x">(forward) && c.set<"ctrl_yaw_dps">(yaw_rate));
        fc.receive_draft(c);
    };
    fc.keep_steering(4s, [&] { steer(200, 0); });
    EXPECT_NEAR(fc.flight().body().velocity().x, 2, 0.3);
    fc.keep_steering(3s, [&] { steer(0, 30); });
    EXPECT_NEAR(fc.flight().body().angles().yaw / degree, 90, 10);
    fc.keep_steering(3s, [&] {
        steer(200, 0);
        fc.stick(1500, 1500, 1900, 1500);
    });
    EXPECT_LT(fc.flight().body().velocity().y, 0.5) << "sticks off centre: 0x41 does not count";
}

TEST(FlightController, flies_with_every_gain_that_it_accepts) {
    for (int combination = 0; combination < 16; ++combination) {
        FlyingFc fc;
        int bit = 0;
        for (const char* gain : {"SIM_P_POSITION", "SIM_P_VELOCITY", "SIM_P_ATTITUDE", "SIM_P_RATE"})
            ASSERT_TRUE(fc.write(gain, (combination >> bit++ & 1) != 0 ? 1e9f : 0.0f)) << "clamped to its limits";
        ASSERT_TRUE(fc.command(1, std::uint16_t{500}));
        fc.run_for(30s);
        EXPECT_TRUE((fc.place() - Vector{0, 0, 5}).length() < 2) << combination << ": " << fc.place().x << ' ' << fc.place().z;
    }
}

TEST(FlightController, lands_when_the_battery_is_low) {
    FlyingFc fc;
    ASSERT_TRUE(fc.write("SIM_FLIGHT_TIME", std::uint32_t{60}));
    fc.fly_to(2);
    const double first = fc.next<"power">()->get<"voltage">();
    fc.run_for(20s);
    EXPECT_LT(fc.next<"power">()->get<"voltage">(), first - 0.3);
    fc.said.clear();
    ASSERT_TRUE(fc.run_until([&] { return fc.flight().safety() == Flight::Safety::locked; }));
    EXPECT_TRUE(fc.has_sent_text("battery low"));
    EXPECT_TRUE(fc.has_sent_text("landed"));
    EXPECT_GT(fc.flight().battery().charge(), 0) << "in time";
    EXPECT_FALSE(fc.command(1, std::uint16_t{100})) << "not with this battery";
    ASSERT_TRUE(fc.write("SIM_CHARGE", std::uint8_t{100}));
    EXPECT_TRUE(fc.command(1, std::uint16_t{100}));
}

TEST(FlightController, sends_pictures_of_all_colors_in_turn) {
    FlyingFc fc;
    fc.run_for(10s);
    std::map<int, std::size_t> pixels;
    std::vector<int> colors;
    for (const Bytes& f : fc.said)
        if (const auto image = ano::as<"image">(ano::FrameView{f})) {
            pixels[image->get<"flag">()] += image->get<"pixels">().size();
            if (colors.empty() || colors.back() != image->get<"color">()) colors.push_back(image->get<"color">());
            EXPECT_EQ(image->get<"width">() * image->get<"height">(), 48 * 32);
        }
    ASSERT_GE(colors.size(), 8u);
    for (std::size_t i = 0; i < colors.size(); ++i) EXPECT_EQ(colors[i], static_cast<int>(i % 7));
    EXPECT_EQ(pixels[0], 48u * 32) << "grey: a byte a pixel";
    EXPECT_EQ(pixels[1], 6u * 32) << "a bit a pixel";
    ASSERT_TRUE(fc.write("SIM_PICTURES", std::uint8_t{0}));
    fc.said.clear();
    fc.run_for(3s);
    EXPECT_EQ(fc.count(0xB0), 0u);
}

TEST(FlightController, scans_the_walls_around_it) {
    FlyingFc fc;
    const auto points = fc.next<"ranging", "scan">()->get<"points">();
    ASSERT_EQ(points.size(), 36u * 4);
    EXPECT_EQ(ano::load<std::uint16_t>(points.data() + 2), 3000) << "ahead";
    EXPECT_EQ(ano::load<std::uint16_t>(points.data() + 9 * 4), 9000) << "90°";
    EXPECT_EQ(ano::load<std::uint16_t>(points.data() + 9 * 4 + 2), 2000) << "to the right";
}

TEST(FlightController, sends_at_its_rates_and_does_not_catch_up_after_a_pause) {
    FlyingFc fc{Settings{.id = 0, .hz = 100, .seed = 1}};
    fc.run_for(10s);
    EXPECT_EQ(fc.count(0x01), 1000u);
    EXPECT_EQ(fc.count(0x03), 1000u);
    for (const int id : {0x02, 0x04, 0x05, 0x07}) EXPECT_EQ(fc.count(static_cast<std::uint8_t>(id)), 500u) << id;
    for (const int id : {0x06, 0x0A, 0x0B, 0x20}) EXPECT_EQ(fc.count(static_cast<std::uint8_t>(id)), 100u) << id;
    EXPECT_EQ(fc.count(0x30), 50u);
    for (const int id : {0x09, 0x0C, 0x0D, 0x0E, 0x0F, 0xF9}) EXPECT_EQ(fc.count(static_cast<std::uint8_t>(id)), 10u) << id;
    fc.said.clear();
    fc.now += 10s;
    fc.device.run(fc.now, fc.receive);
    for (int id = 0; id < 256; ++id) EXPECT_LE(fc.count(static_cast<std::uint8_t>(id)), 2u) << id;
    EXPECT_LE(fc.device.due(), fc.now + 10ms);
}

TEST(FlightController, ignores_frames_for_other_devices) {
    FlyingFc fc;
    const Bytes take_off = frame(0xFE, 0xDB, 0xC0, {0x10, 0, 1, 0x2C, 0x01});
    fc.device.take(ano::FrameView{take_off}, fc.now, fc.receive);
    EXPECT_TRUE(fc.said.empty());
    EXPECT_EQ(fc.flight().safety(), Flight::Safety::locked);
}

}    // namespace
}    // namespace flight_controller_tests
