#include <gtest/gtest.h>
#include <ano/typed.hpp>
#include <ano/wire.hpp>
#include <gateway/simulated_fc.hpp>

#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include <support/bytes.hpp>

namespace {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using support::operator+;

constexpr std::uint8_t host = 0xFE, fc_id = 0xDC;

struct Flight {
    static constexpr ano::TimePoint start{1000s};
    SimulatedFc fc{100, start};
    std::vector<Bytes> said;
    const SimulatedFc::Send hear = [this](ano::FrameView f) { said.emplace_back(f.bytes().begin(), f.bytes().end()); };

    std::vector<Bytes> answers(std::uint8_t id, const Bytes& data, std::uint8_t to = fc_id) {
        said.clear();
        const Bytes question = frame(host, to, id, data);
        fc.receive(ano::FrameView{question}, start, hear);
        return said;
    }
    Bytes acknowledgement(std::uint8_t id, const Bytes& data) const {
        const Bytes question = frame(host, fc_id, id, data);
        return frame(fc_id, host, 0x00, {id, question[question.size() - 2], question.back()});
    }
    // The last frame of that message that it sends in the next second.
    template <ano::Name M>
    ano::View<M> telemetry() {
        const ano::TimePoint end = now + 1s;
        for (; now < end; now += 10ms) fc.run(now, hear);
        for (auto f = said.rbegin(); f != said.rend(); ++f)
            if (const auto view = ano::as<M>(ano::FrameView{*f})) return kept(*view);
        ADD_FAILURE() << "it does not say " << M.view();
        return ano::View<M>{zeros};
    }
    template <class View>
    View kept(View view) {
        last.assign(view.data().begin(), view.data().end());
        return View{last};
    }
    std::uint16_t id_of_parameter(std::string_view name) {
        for (std::uint8_t id = 0; id < 33; ++id)
            for (const Bytes& f : answers(0xE0, {3, id, 0}))
                if (const auto info = ano::as<"parameter_info">(ano::FrameView{f}); info && info->get<"name">() == name)
                    return id;
        ADD_FAILURE() << "no parameter " << name;
        return 0;
    }
    template <class T>
    void write(std::string_view name, T value) {
        Bytes data{static_cast<std::uint8_t>(id_of_parameter(name)), 0};
        data.resize(2 + sizeof value);
        ano::store(data.data() + 2, value);
        EXPECT_EQ(answers(0xE1, data), (std::vector<Bytes>{acknowledgement(0xE1, data)}));
    }

    ano::TimePoint now = start;
    Bytes last, zeros = Bytes(32);
};

TEST(SimulatedFc, says_who_it_is) {
    Flight flight;
    const Bytes expected = frame(fc_id, host, 0xE3, support::hex("DC 64 00 64 00 00 00 20 03 53 69 6D 46 43"));
    EXPECT_EQ(flight.answers(0xE0, {0, 0, 0}), (std::vector<Bytes>{expected}));
    EXPECT_EQ(flight.answers(0xE0, {0, 0, 0}, 0xFF), (std::vector<Bytes>{expected}));
    EXPECT_TRUE(flight.answers(0xE0, {0, 0, 0}, 0xDB).empty());
    EXPECT_TRUE(flight.answers(0xE0, {}).empty());
}

TEST(SimulatedFc, has_parameters_of_all_types) {
    Flight flight;
    EXPECT_EQ(flight.answers(0xE0, {1, 0, 0}), (std::vector<Bytes>{frame(fc_id, host, 0xE0, {1, 33, 0})}));
    std::set<int> types;
    for (std::uint8_t id = 0; id < 33; ++id) {
        const auto described = flight.answers(0xE0, {3, id, 0});
        ASSERT_EQ(described.size(), 1u);
        const auto info = ano::as<"parameter_info">(ano::FrameView{described.front()});
        ASSERT_TRUE(info);
        types.insert(info->get<"par_type">());
        EXPECT_EQ(flight.answers(0xE0, {2, id, 0}).size(), 1u);
    }
    EXPECT_EQ(types.size(), 11u);
    EXPECT_TRUE(flight.answers(0xE0, {2, 33, 0}).empty());
}

TEST(SimulatedFc, hovers_as_it_is_set) {
    Flight flight;
    EXPECT_NEAR(flight.telemetry<"altitude">().get<"alt_fu">(), 120, 5);
    EXPECT_NEAR(flight.telemetry<"inertial">().get<"acc_z">(), 981, 6);
    flight.write("SIM_HEIGHT", std::uint16_t{500});
    flight.write("SIM_SWAY", 0.0f);
    flight.write("SIM_BAR_OFFSET", std::int16_t{-100});
    flight.write("SIM_RANGE_OFFSET", std::int32_t{7});
    const auto altitude = flight.telemetry<"altitude">();
    EXPECT_EQ(altitude.get<"alt_fu">(), 500);
    EXPECT_EQ(altitude.get<"alt_bar">(), 400);
    EXPECT_EQ(altitude.get<"alt_add">(), 507);
    EXPECT_EQ(flight.telemetry<"euler">().get<"rol">(), 0);
    flight.write("SIM_TURN", std::int8_t{-30});
    EXPECT_NEAR(flight.telemetry<"inertial">().get<"gyr_z">(), -30, 0.1);
    flight.write("SIM_MODE", std::uint8_t{1});
    EXPECT_EQ(flight.telemetry<"mode">().get<"mode">(), 1);
    flight.write("SIM_FLIGHT_TIME", std::uint32_t{60});
    flight.now = Flight::start + 58s;
    EXPECT_LT(flight.telemetry<"power">().get<"voltage">(), 10.9);
}

TEST(SimulatedFc, is_corrected_by_its_calibration) {
    Flight flight;
    flight.write("CAL_AOFF_Z", 81.0f);
    flight.write("CAL_ASEN_Z", 2.0f);
    EXPECT_NEAR(flight.telemetry<"inertial">().get<"acc_z">(), 1800, 11);
    flight.write("CAL_AEM1_Z", 0.5f);
    EXPECT_NEAR(flight.telemetry<"inertial">().get<"acc_x">(), 900, 14);
    flight.write("CAL_ASEN_Z", 1e30f);
    EXPECT_EQ(flight.telemetry<"inertial">().get<"acc_z">(), 32767) << "as much as the message carries";
    const Bytes clear{0x10, 0x20, 0};
    EXPECT_EQ(flight.answers(0xE0, clear), (std::vector<Bytes>{flight.acknowledgement(0xE0, clear)}));
    EXPECT_NEAR(flight.telemetry<"inertial">().get<"acc_z">(), 981, 6);
    const Bytes stored{0x10, 0x21, 0};
    EXPECT_EQ(flight.answers(0xE0, stored), (std::vector<Bytes>{flight.acknowledgement(0xE0, stored)}));
}

TEST(SimulatedFc, lands_and_takes_off) {
    Flight flight;
    const Bytes land{0x10, 0, 2}, take_off{0x10, 0, 1, 0x2C, 0x01};
    EXPECT_EQ(flight.telemetry<"mode">().get<"sflag">(), 2);
    const auto landed = flight.answers(0xC0, land);
    ASSERT_EQ(landed.size(), 2u) << "a line of its log, and the acknowledgement";
    EXPECT_EQ(landed.back(), flight.acknowledgement(0xC0, land));
    EXPECT_EQ(flight.telemetry<"mode">().get<"sflag">(), 0);
    EXPECT_EQ(flight.telemetry<"altitude">().get<"alt_fu">(), 0);
    EXPECT_EQ(flight.telemetry<"velocity">().get<"speed_x">(), 0);
    EXPECT_EQ(flight.answers(0xC0, take_off).back(), flight.acknowledgement(0xC0, take_off));
    EXPECT_EQ(flight.telemetry<"mode">().get<"sflag">(), 2);
    EXPECT_NEAR(flight.telemetry<"altitude">().get<"alt_fu">(), 300, 5);
    EXPECT_TRUE(flight.answers(0xC0, {0x10, 0, 1, 1, 0}).empty()) << "1 cm is no height";
    EXPECT_TRUE(flight.answers(0xC0, {0x10, 0, 9}).empty());
}

TEST(SimulatedFc, describes_its_commands) {
    Flight flight;
    EXPECT_EQ(flight.answers(0xC1, {0, 0, 0}), (std::vector<Bytes>{frame(fc_id, host, 0xC1, {0, 5, 0})}));
    const auto add = flight.answers(0xC1, {1, 4, 0});
    ASSERT_EQ(add.size(), 1u);
    const auto types = ano::as<"command_info">(ano::FrameView{add.front()})->get<"val_type">();
    EXPECT_EQ(Bytes(types.begin(), types.end()), (Bytes{1, 2, 3, 4, 5, 6, 7, 10}));
    const Bytes values = Bytes{1, 0xFF, 2, 0, 3, 0, 4, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0x40} +
                         support::hex("00 00 00 00 00 00 F0 3F");
    const auto sum = flight.answers(0xC0, Bytes{0x10, 0, 5} + values);
    ASSERT_EQ(sum.size(), 2u);
    EXPECT_EQ(ano::as<"log_value">(ano::FrameView{sum.front()})->get<"val">(), 17);
}

TEST(SimulatedFc, keeps_waypoints) {
    Flight flight;
    EXPECT_EQ(flight.answers(0x60, {0xFF}), (std::vector<Bytes>{frame(fc_id, host, 0x60, {1})}));
    const auto home = flight.answers(0x60, {0});
    ASSERT_EQ(home.size(), 1u);
    EXPECT_DOUBLE_EQ(ano::as<"waypoint">(ano::FrameView{home.front()})->get<"lng">(), 116.3);
    const Bytes next = Bytes{1} + Bytes(21, 3) + Bytes(2);
    EXPECT_EQ(flight.answers(0x61, next), (std::vector<Bytes>{flight.acknowledgement(0x61, next)}));
    EXPECT_EQ(flight.answers(0x60, {0xFF}), (std::vector<Bytes>{frame(fc_id, host, 0x60, {2})}));
}

TEST(SimulatedFc, does_not_make_up_for_a_pause) {
    Flight flight;
    flight.fc.run(Flight::start, flight.hear);
    flight.said.clear();
    flight.fc.run(Flight::start + 10s, flight.hear);
    EXPECT_EQ(flight.said.size(), 6u) << "one of each";
    EXPECT_EQ(flight.fc.next(), Flight::start + 10s + 10ms);
}

}    // namespace
