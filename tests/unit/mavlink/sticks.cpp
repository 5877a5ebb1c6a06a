// Sticks of a ground station: who controls a vehicle, when it is stopped, and what is sent.
#include <mavlink/stick_control.hpp>
#include <mavlink/typed.hpp>

#include <ano/typed.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>

#include <cmath>
#include <limits>
#include <numbers>

namespace mavlink_sticks_tests {
namespace {

using namespace anogate::mavlink;
using namespace std::chrono_literals;
using support::Bytes;

constexpr unsigned only_velocity = 0x5C7;    // with a yaw rate
constexpr std::uint8_t body = 8, ground = 1;

class Sticks : public testing::Test {
protected:
    void mode(unsigned number) {
        ano::Draft<"mode"> draft;
        ASSERT_TRUE(draft.set<"mode">(number) && draft.set<"sflag">(2));
        Bytes bytes(64);
        bytes.resize(draft.encode(bytes, 0xDC, 0xFF));
        state.receive(ano::read(*ano::frame_at(bytes)), now);
    }
    void heading(double left) {
        ano::Draft<"euler"> draft;
        ASSERT_TRUE(draft.set<"yaw">(left));
        Bytes bytes(64);
        bytes.resize(draft.encode(bytes, 0xDC, 0xFF));
        state.receive(ano::read(*ano::frame_at(bytes)), now);
    }
    template <class D>
    StickFault receive(const D& draft, std::uint8_t station = 255, ano::Duration waited = {}) {
        Bytes bytes(max_packet);
        bytes.resize(encode(bytes, Version::v2, {station, 190}, 0, draft.row, draft.payload()));
        return control.receive(PacketView{bytes}, now - waited, now, state, frame);
    }
    static auto velocity(float x, float y, float z, float turn = 0, std::uint8_t axes = body, std::uint32_t sent_ms = 0) {
        Draft<"SET_POSITION_TARGET_LOCAL_NED"> draft;
        draft.set<"type_mask">(only_velocity).set<"coordinate_frame">(axes).set<"vx">(x).set<"vy">(y).set<"vz">(z);
        return draft.set<"yaw_rate">(turn).set<"time_boot_ms">(sent_ms);
    }
    static auto sticks(int x, int y, int z, int r) {
        Draft<"MANUAL_CONTROL"> draft;
        return draft.set<"x">(x).set<"y">(y).set<"z">(z).set<"r">(r);
    }
    RealtimeFrame realtime() const { return std::get<RealtimeFrame>(frame); }

    static StickSettings settings() {
        StickSettings all;
        all.accepts = {true, true, true, true};
        all.hover_throttle = 45;
        all.aux = {1000, 1100, 1200, 1300, 1400, 1500};
        return all;
    }
    VehicleState state;
    StickControl control{settings()};
    StickFrame frame;
    ano::TimePoint now{1h};
};

TEST_F(Sticks, are_refused_unless_they_are_allowed_by_name) {
    control = StickControl{{}};
    EXPECT_EQ(receive(sticks(0, 0, 500, 0)), StickFault::not_allowed);
    EXPECT_EQ(receive(velocity(0, 0, 0)), StickFault::not_allowed);
    EXPECT_EQ(receive(Draft<"HEARTBEAT">{}), StickFault::not_sticks);
}

TEST_F(Sticks, become_channels) {
    EXPECT_EQ(receive(sticks(1000, -500, 300, 1000)), StickFault::none);    // forward, left, a little thrust, turns to the right
    EXPECT_EQ(std::get<ChannelFrame>(frame).channels,
              (std::array<std::int16_t, 10>{1250, 2000, 1300, 2000, 1000, 1100, 1200, 1300, 1400, 1500}));
    EXPECT_EQ(receive(sticks(1001, 0, 0, 0)), StickFault::malformed);
    EXPECT_EQ(receive(sticks(0, 0, -1, 0)), StickFault::malformed);
    EXPECT_EQ(receive(sticks(0, 0, 0, std::numeric_limits<std::int16_t>::max())), StickFault::malformed);    // not stated
}

TEST_F(Sticks, overrides_need_the_four_sticks) {
    Draft<"RC_CHANNELS_OVERRIDE"> draft;
    draft.set<"chan1_raw">(1500).set<"chan2_raw">(1600).set<"chan4_raw">(1500).set<"chan5_raw">(2000);
    EXPECT_EQ(receive(draft), StickFault::malformed);    // the throttle is given back to the radio
    draft.set<"chan3_raw">(1400);
    EXPECT_EQ(receive(draft), StickFault::none);
    EXPECT_EQ(std::get<ChannelFrame>(frame).channels,
              (std::array<std::int16_t, 10>{1500, 1600, 1400, 1500, 2000, 1100, 1200, 1300, 1400, 1500}));
    draft.set<"chan3_raw">(0xFFFF);
    EXPECT_EQ(receive(draft), StickFault::malformed);
}

TEST_F(Sticks, velocities_are_forward_left_up_with_a_throttle) {
    EXPECT_EQ(receive(velocity(1, 2, -0.5F)), StickFault::unknown_mode);
    mode(1);
    EXPECT_EQ(receive(velocity(1, 2, -0.5F)), StickFault::wrong_mode);
    mode(2);
    EXPECT_EQ(receive(velocity(1, 2, -0.5F, std::numbers::pi_v<float> / 2)), StickFault::none);
    EXPECT_EQ(realtime(), (RealtimeFrame{0, 0, 45, -90, 100, -200, 50}));
    heading(90);                                                           // to the west
    EXPECT_EQ(receive(velocity(1, 2, 0, 0, ground)), StickFault::none);    // north, east
    EXPECT_EQ(realtime().x, -200);
    EXPECT_EQ(realtime().y, -100);
    EXPECT_EQ(receive(velocity(std::nanf(""), 0, 0)), StickFault::malformed);
    EXPECT_EQ(receive(velocity(0, 0, 0, 0, 7)), StickFault::malformed);
    EXPECT_EQ(receive(velocity(1, 0, 0).set<"type_mask">(0)), StickFault::malformed);    // a position
}

TEST_F(Sticks, attitudes_never_lack_a_throttle) {
    mode(0);
    Draft<"SET_ATTITUDE_TARGET"> draft;
    const double half = 10 * std::numbers::pi / 360;
    draft.set<"type_mask">(3).set<"q">(std::cos(half)).set<"q">(std::sin(half), 2).set<"thrust">(0.6F);    // nose up
    EXPECT_EQ(receive(draft), StickFault::none);
    EXPECT_NEAR(realtime().pitch, -10, 1e-3);
    EXPECT_NEAR(realtime().roll, 0, 1e-3);
    EXPECT_NEAR(realtime().throttle, 60, 1e-3);
    draft.set<"type_mask">(3 | 64);
    EXPECT_EQ(receive(draft), StickFault::none);
    EXPECT_EQ(realtime().throttle, 45);
    draft.set<"thrust">(-0.5F).set<"type_mask">(3);
    EXPECT_EQ(receive(draft), StickFault::malformed);
    mode(2);
    EXPECT_EQ(receive(draft.set<"thrust">(0.5F)), StickFault::wrong_mode);
}

TEST_F(Sticks, are_those_of_one_station_until_it_is_silent_for_half_a_second) {
    EXPECT_EQ(receive(sticks(0, 0, 500, 0), 255), StickFault::none);
    now += 499ms;
    EXPECT_EQ(receive(sticks(0, 0, 500, 0), 254), StickFault::other_station);
    EXPECT_EQ(control.station(now), (Origin{255, 190}));
    now += 1ms;
    EXPECT_EQ(receive(sticks(0, 0, 500, 0), 254), StickFault::none);
    EXPECT_EQ(receive(sticks(0, 0, 500, 0), 255), StickFault::other_station);
}

TEST_F(Sticks, that_waited_are_not_used) {
    EXPECT_EQ(receive(sticks(0, 0, 500, 0), 255, 200ms), StickFault::none);
    EXPECT_EQ(receive(sticks(0, 0, 500, 0), 255, 201ms), StickFault::old);
    mode(2);
    EXPECT_EQ(receive(velocity(1, 0, 0, 0, body, 10'000)), StickFault::none);
    now += 100ms;
    EXPECT_EQ(receive(velocity(1, 0, 0, 0, body, 10'100)), StickFault::none);
    now += 350ms;
    EXPECT_EQ(receive(velocity(1, 0, 0, 0, body, 10'200)), StickFault::old);    // 250 ms on the way
    EXPECT_EQ(receive(velocity(1, 0, 0, 0, body, 10'300)), StickFault::none);
}

TEST_F(Sticks, of_a_station_whose_clock_was_set_back_are_used_after_five_seconds) {
    mode(2);
    EXPECT_EQ(receive(velocity(1, 0, 0, 0, body, 900'000)), StickFault::none);
    int used = 0;
    for (std::uint32_t ms = 100; ms < 8000; ms += 100) {
        now += 100ms;
        mode(2);
        used += receive(velocity(1, 0, 0, 0, body, ms)) == StickFault::none ? 1 : 0;
    }
    EXPECT_NEAR(used, 28, 3);
}

TEST_F(Sticks, a_vehicle_whose_station_is_silent_is_stopped_once) {
    mode(2);
    EXPECT_EQ(receive(velocity(1, 0, 0)), StickFault::none);
    EXPECT_EQ(control.due(), now + 500ms);
    now += 499ms;
    EXPECT_FALSE(control.on_time(now, state));
    now += 1ms;
    EXPECT_EQ(control.on_time(now, state), StickFrame{(RealtimeFrame{0, 0, 45, 0, 0, 0, 0})});
    EXPECT_FALSE(control.on_time(now, state));
    EXPECT_FALSE(control.due());
    EXPECT_EQ(receive(velocity(1, 0, 0)), StickFault::none);
    now += 600ms;
    mode(0);    // the throttle would count
    EXPECT_FALSE(control.on_time(now, state));
}

}    // namespace
}    // namespace mavlink_sticks_tests
