// Commands of ground stations: what they become for a device, and that each is carried out once.
#include <mavlink/command_executions.hpp>
#include <mavlink/typed.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>

#include <cmath>
#include <limits>
#include <numbers>

namespace mavlink_commands_tests {
namespace {

using namespace anogate::mavlink;
using namespace std::chrono_literals;
using support::Bytes;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr Home home{310'000'000, 1'210'000'000, 40};

CommandContext context(Autopilot autopilot = Autopilot::px4) { return {autopilot, home, Vector{10, 5, -2}}; }

StationCommand command(Command number, std::array<double, 7> parameters = {}, std::optional<std::uint8_t> frame = std::nullopt) {
    return {{255, 190}, 1, 1, static_cast<std::uint16_t>(number), parameters, 0, frame};
}

Wish wish(const StationCommand& what, const CommandContext& known = context()) {
    const auto answer = wish_of(what, known);
    EXPECT_TRUE(std::holds_alternative<Wish>(answer));
    return std::holds_alternative<Wish>(answer) ? std::get<Wish>(answer) : Wish{};
}
Result refusal(const StationCommand& what, const CommandContext& known = context()) {
    const auto answer = wish_of(what, known);
    EXPECT_TRUE(std::holds_alternative<Result>(answer));
    return std::holds_alternative<Result>(answer) ? std::get<Result>(answer) : Result::accepted;
}

TEST(WishOf, arms_disarms_and_stops) {
    EXPECT_EQ(wish(command(Command::arm_disarm, {1})).action, Action::arm);
    EXPECT_EQ(wish(command(Command::arm_disarm, {0})).action, Action::disarm);
    EXPECT_EQ(wish(command(Command::arm_disarm, {0, 21'196})).action, Action::stop);
    EXPECT_EQ(refusal(command(Command::arm_disarm, {2})), Result::denied);
}

TEST(WishOf, takes_off_to_a_height_above_home) {
    const std::array<double, 7> to_50{-1, 0, 0, none, none, none, 50};
    EXPECT_DOUBLE_EQ(wish(command(Command::nav_takeoff, to_50)).height, 10);    // PX4: above sea level
    EXPECT_DOUBLE_EQ(wish(command(Command::nav_takeoff, to_50), context(Autopilot::ardupilot)).height, 50);
    EXPECT_DOUBLE_EQ(wish(command(Command::nav_takeoff, to_50, 3)).height, 50);    // COMMAND_INT states the frame
    EXPECT_DOUBLE_EQ(wish(command(Command::nav_takeoff, {-1, 0, 0, none, none, none, none})).height, 0);
    EXPECT_EQ(refusal(command(Command::nav_takeoff, {-1, 0, 0, none, none, none, 30})), Result::denied);    // below home
    EXPECT_EQ(refusal(command(Command::nav_takeoff, to_50), {Autopilot::px4, {}, {}}), Result::denied);
}

TEST(WishOf, pauses_turns_and_goes_to_places) {
    EXPECT_EQ(wish(command(Command::do_reposition, {-1, 1, 0, none, none, none, none})).action, Action::hold);
    const Wish turned = wish(command(Command::do_reposition, {-1, 1, 0, std::numbers::pi / 2, none, none, none}));
    EXPECT_EQ(turned.action, Action::yaw);
    EXPECT_DOUBLE_EQ(turned.heading, 90);
    const Wish there = wish(command(Command::do_reposition, {-1, 1, 0, none, 31.001, 120.999, 47}));
    EXPECT_EQ(there.action, Action::go_to);
    EXPECT_NEAR(there.north, 111.19, 0.01);
    EXPECT_NEAR(there.west, 111.19 * std::cos(31 * std::numbers::pi / 180), 0.01);
    EXPECT_DOUBLE_EQ(there.up, 7);
    const Wish higher = wish(command(Command::do_reposition, {-1, 1, 0, none, none, none, 45}));
    EXPECT_DOUBLE_EQ(higher.north, 10);
    EXPECT_DOUBLE_EQ(higher.west, -5);
    EXPECT_DOUBLE_EQ(higher.up, 5);
    EXPECT_DOUBLE_EQ(wish(command(Command::do_reposition, {-1, 1, 0, none, 31, 121, 6}, 6)).up, 6);
    EXPECT_EQ(refusal(command(Command::do_reposition, {-1, 1, 0, none, 91, 121, 50})), Result::denied);
    EXPECT_EQ(refusal(command(Command::do_reposition, {-1, 1, 0, none, 31, none, 50})), Result::denied);
    EXPECT_EQ(refusal(command(Command::do_reposition, {-1, 1, 0, none, 31, 121, 50}), {}), Result::temporarily_rejected);
    EXPECT_EQ(refusal(command(Command::do_reposition, {-1, 1, 0, none, 31, 121, 50}, 10)), Result::denied);    // above terrain
    EXPECT_DOUBLE_EQ(wish(command(Command::condition_yaw, {270})).heading, 270);
    EXPECT_EQ(refusal(command(Command::condition_yaw, {30, 0, 1, 1})), Result::denied);
}

TEST(WishOf, selects_modes) {
    EXPECT_EQ(wish(command(Command::do_set_mode, {1, 4, 5})).action, Action::return_home);
    EXPECT_EQ(wish(command(Command::do_set_mode, {1, 4, 6})).action, Action::land);
    EXPECT_EQ(wish(command(Command::do_set_mode, {1, 4, 4})).action, Action::start_mission);
    EXPECT_EQ(wish(command(Command::do_set_mode, {1, 4, 3})).action, Action::hold);
    EXPECT_EQ(wish(command(Command::do_set_mode, {1, 3})).mode, 2);
    EXPECT_EQ(wish(command(Command::do_set_mode, {1, 2}), context(Autopilot::ardupilot)).mode, 1);
    EXPECT_EQ(refusal(command(Command::do_set_mode, {1, 77})), Result::unsupported);
    EXPECT_EQ(refusal(command(Command::do_set_mode, {0, 4, 5})), Result::unsupported);
    EXPECT_EQ(refusal(command(Command::request_message, {148})), Result::unsupported);
}

TEST(StationCommandOf, reads_all_three_messages) {
    const auto read = [](const auto& draft) {
        Bytes bytes(max_packet);
        bytes.resize(encode(bytes, Version::v2, {255, 190}, 0, draft.row, draft.payload()));
        return station_command(PacketView{bytes});
    };
    Draft<"COMMAND_LONG"> in_floats;
    in_floats.set<"target_system">(1).set<"target_component">(2).set<"command">(400).set<"param1">(1.0F).set<"confirmation">(3);
    const auto a = read(in_floats);
    ASSERT_TRUE(a);
    EXPECT_EQ(a->from, (Origin{255, 190}));
    EXPECT_EQ(a->target_component, 2);
    EXPECT_EQ(a->command, 400);
    EXPECT_EQ(a->confirmation, 3);
    EXPECT_FALSE(a->frame);
    Draft<"COMMAND_INT"> in_integers;
    in_integers.set<"command">(192).set<"frame">(6).set<"x">(310'000'001).set<"y">(std::numeric_limits<std::int32_t>::max());
    const auto b = read(in_integers);
    ASSERT_TRUE(b);
    EXPECT_DOUBLE_EQ(b->parameters[4], 31.0000001);
    EXPECT_TRUE(std::isnan(b->parameters[5]));
    EXPECT_EQ(b->frame, 6);
    Draft<"SET_MODE"> mode;
    mode.set<"target_system">(1).set<"base_mode">(1).set<"custom_mode">(4u << 16 | 5u << 24);
    EXPECT_EQ(wish(*read(mode)).action, Action::return_home);
    EXPECT_FALSE(read(Draft<"HEARTBEAT">{}));
}

TEST(CommandFor, has_the_values_of_the_table) {
    const auto rows = named_commands();
    Wish there{.action = Action::go_to, .north = 1.5, .west = -2.25, .up = 3};
    const auto go = command_for(*find_row(rows, Action::go_to), there);
    ASSERT_TRUE(go);
    EXPECT_EQ(go->name, "GO_TO");
    EXPECT_EQ(go->values, (std::vector<CommandNumber>{{ano::Type::i64, 150}, {ano::Type::i64, -225}, {ano::Type::u16, 300}}));
    there.up = -1;
    EXPECT_FALSE(command_for(*find_row(rows, Action::go_to), there));
    const auto left = command_for(*find_row(rows, Action::yaw), {.action = Action::yaw, .heading = 90});
    EXPECT_EQ(left->values, (std::vector<CommandNumber>{{ano::Type::i16, -90}}));
    const auto vendor = vendor_commands();
    const auto up = command_for(*find_row(vendor, Action::take_off), {.action = Action::take_off, .height = 1.5});
    EXPECT_EQ(up->cid, (Cid{0x10, 0, 5}));
    EXPECT_EQ(up->values, (std::vector<CommandNumber>{{ano::Type::u16, 150}}));
    EXPECT_EQ(find_row(vendor, Action::go_to), nullptr);
    EXPECT_FALSE(command_for(*find_row(vendor, Action::take_off), {.action = Action::take_off, .height = 700}));
}

class Executions : public testing::Test {
protected:
    StationCommand sent(Command number, double first = 0, std::uint8_t confirmation = 0, Origin from = {255, 190}) {
        StationCommand what = command(number, {first});
        what.confirmation = confirmation;
        what.from = from;
        return what;
    }
    void receive(const StationCommand& what) { executions.receive(what, now); }
    void finish(Result result) {
        const auto done = std::move(waiting.front());
        waiting.erase(waiting.begin());
        done(result);
    }

    std::vector<CommandExecutions::Done> waiting;
    int carried_out = 0;
    std::vector<Result> answers;
    CommandExecutions executions{[this](const StationCommand&, CommandExecutions::Done done) {
                                     ++carried_out;
                                     waiting.push_back(std::move(done));
                                 },
                                 [this](const StationCommand&, Result result) { answers.push_back(result); }};
    ano::TimePoint now{1h};
};

TEST_F(Executions, a_command_is_in_progress_until_the_device_answers) {
    receive(sent(Command::nav_takeoff));
    EXPECT_EQ(answers, std::vector{Result::in_progress});
    finish(Result::accepted);
    EXPECT_EQ(answers, (std::vector{Result::in_progress, Result::accepted}));
}

TEST_F(Executions, a_repeated_command_is_carried_out_once) {
    receive(sent(Command::nav_takeoff));
    for (std::uint8_t i = 1; i < 10; ++i) {
        now += 500ms;
        receive(sent(Command::nav_takeoff, 0, i));
    }
    finish(Result::accepted);
    for (std::uint8_t i = 10; i < 20; ++i) {
        now += 3s;
        receive(sent(Command::nav_takeoff, 0, i));
    }
    EXPECT_EQ(carried_out, 1);
    EXPECT_EQ(executions.repeats(), 19u);
    EXPECT_EQ(answers.back(), Result::accepted);
    EXPECT_EQ(answers.size(), 1u + 9u + 1u + 10u);
}

TEST_F(Executions, a_station_that_does_not_count_its_repeats_is_recognised_for_five_seconds) {
    receive(sent(Command::nav_takeoff));
    finish(Result::accepted);
    for (int i = 0; i < 4; ++i) {
        now += 3s;
        receive(sent(Command::nav_takeoff));
    }
    EXPECT_EQ(carried_out, 1);
    now += 6s;
    receive(sent(Command::nav_takeoff));
    EXPECT_EQ(carried_out, 2);
}

TEST_F(Executions, the_same_command_after_another_one_is_new) {
    for (const double arms : {1.0, 0.0, 1.0}) {
        receive(sent(Command::arm_disarm, arms));
        finish(Result::accepted);
    }
    EXPECT_EQ(carried_out, 3);
    receive(sent(Command::arm_disarm, 0, 1));    // a late repeat of the one before
    EXPECT_EQ(carried_out, 3);
}

TEST_F(Executions, stations_do_not_repeat_each_other) {
    receive(sent(Command::nav_land));
    receive(sent(Command::nav_land, 0, 0, {254, 190}));
    EXPECT_EQ(carried_out, 2);
}

TEST_F(Executions, another_command_of_the_same_kind_waits_for_the_first) {
    receive(sent(Command::arm_disarm, 1));
    receive(sent(Command::arm_disarm, 0));
    EXPECT_EQ(answers.back(), Result::temporarily_rejected);
    EXPECT_EQ(carried_out, 1);
}

TEST_F(Executions, remembers_no_more_than_it_may) {
    for (int i = 0; i < 1000; ++i) receive(sent(Command::do_change_speed, i, 0, {static_cast<std::uint8_t>(i % 250), 1}));
    EXPECT_LE(carried_out, static_cast<int>(CommandExecutions::max_kept));
    EXPECT_EQ(answers.back(), Result::temporarily_rejected);
}

}    // namespace
}    // namespace mavlink_commands_tests
