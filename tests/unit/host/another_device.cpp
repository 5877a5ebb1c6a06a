// Another device replaces the one that a task works on: no frame that acts is sent to it.
#include <host/calibration.hpp>
#include <host/commands.hpp>
#include <host/firmware.hpp>
#include <host/parameter_apply.hpp>
#include <host/waypoints.hpp>

#include <support/calibrated_device.hpp>
#include <support/fake_device.hpp>
#include <support/fake_loader.hpp>

#include <gtest/gtest.h>

namespace ano::host::another_device_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using support::FakeDevice;
using support::FakeLoader;
using support::Simulation;
using State = ParameterApply::State;

struct Other {
    bool has_other_info = true, has_other_names = false, has_more = false;
    bool link_was_down = false, is_announced = false;
    Duration silent{};
};

/// After `after` acting frames with the id `at_id`, the next one is lost, and another device has the address.
struct Swapped : testing::Test {
    FakeDevice fake;
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = 10ms}};
    Other other;
    std::uint8_t at_id = 0xE1;
    std::size_t after = 2, seen = 0;
    bool is_swapped = false, is_one = true;
    TimePoint receives_from{};
    TimePoint deaf_until{};
    std::size_t questions = 0;    // for its device info
    std::vector<Bytes> acted;     // frames that acted on the other device
    std::function<std::optional<std::vector<Bytes>>(FrameView)> before;

    Swapped() {
        fake.make_parameters(10, 0);
        fake.commands = {{{16, 0, 2}, {}, "LAND", ""}};
        fake.instead = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
            if (is_one && !is_swapped && frame.id() == at_id && intent_of(frame) == Intent::acts && seen++ == after) {
                swap();
                return std::vector<Bytes>{};
            }
            if (is_swapped && simulation.now < receives_from) return std::vector<Bytes>{};
            if (is_swapped && intent_of(frame) == Intent::acts) acted.emplace_back(frame.bytes().begin(), frame.bytes().end());
            return before ? before(frame) : std::nullopt;
        };
        identify();
    }
    void identify() {
        Commands commands{device};
        commands.read(simulation.now);
        simulation.run(commands);
        Parameters parameters{device};
        parameters.read(Parameters::Values::none, simulation.now);
        simulation.run(parameters);
        ASSERT_TRUE(device.info());
    }
    void swap() {
        is_swapped = true;
        receives_from = simulation.now + other.silent;
        if (other.has_other_info) fake.name = "OTHER", fake.hardware = 200;
        if (other.has_more) fake.parameters.push_back(fake.parameters.back());
        for (auto& parameter : fake.parameters)
            if (other.has_other_names) parameter.name = "X" + parameter.name;
        if (other.link_was_down) device.link_was_down();
        if (!other.is_announced) return;
        const auto info = fake.usual(FrameView{support::frame(0xFE, 0xDC, 0xE0, {0, 0, 0})});
        device.take(FrameView{info.at(0)}, simulation.now + 2 * Device::info_doubled_within);
    }
    /// It stores each value in its flash memory before it acknowledges it, and receives nothing meanwhile.
    void write_slowly() {
        before = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
            if (simulation.now < deaf_until) return std::vector<Bytes>{};
            if (is_question_for_info(frame)) ++questions;
            if (frame.id() != 0xE1) return std::nullopt;
            deaf_until = simulation.now + 400ms;
            for (const Bytes& answer : fake.usual(frame)) simulation.answer_later(answer, 400ms);
            return std::vector<Bytes>{};
        };
    }
    template <class T>
    void run(T& task) {
        task.start(simulation.now);
        simulation.run(task);
        ASSERT_TRUE(task.end());
    }
    void is_left_alone(const Task& task) const {
        EXPECT_TRUE(is_swapped);
        EXPECT_EQ(acted, std::vector<Bytes>{});
        EXPECT_TRUE(task.is_of_another());
        EXPECT_EQ(task.end()->ending, Ending::failed);
        EXPECT_EQ(task.end()->fault.text().find("0xDC became another device in the meantime"), 0u) << task.end()->fault.text();
    }
    std::vector<std::pair<std::string, AnyValue>> values() const {
        std::vector<std::pair<std::string, AnyValue>> all;
        for (int i = 0; i < 6; ++i) all.emplace_back("PAR_" + std::to_string(i), std::int64_t{90 + i});
        return all;
    }
    std::vector<State> states(const ParameterApply& task) const {
        std::vector<State> all;
        for (const auto& row : task.rows()) all.push_back(row.state);
        return all;
    }
};

const Other others[] = {{},
                        {.link_was_down = true},
                        {.is_announced = true},
                        {.silent = 250ms},
                        {.silent = 1s},
                        {.has_other_info = false, .has_other_names = true},
                        {.has_other_info = false, .has_other_names = true, .silent = 250ms},
                        {.has_other_info = false, .has_other_names = true, .link_was_down = true},
                        {.has_other_info = false, .has_more = true, .silent = 300ms}};

struct EachOther : Swapped, testing::WithParamInterface<Other> {
    EachOther() { other = GetParam(); }
};

TEST_P(EachOther, receives_no_value_of_an_import) {
    ParameterApply task{device, nullptr, values()};
    run(task);
    is_left_alone(task);
    EXPECT_EQ(states(task),
              (std::vector{State::written, State::written, State::failed, State::waiting, State::waiting, State::waiting}));
}

TEST_P(EachOther, gets_no_frames_if_the_previous_device_writes_slowly) {
    write_slowly();
    ParameterApply task{device, nullptr, values()};
    run(task);
    is_left_alone(task);
}

TEST_P(EachOther, receives_no_restored_old_value) {
    ParameterApply task{device, nullptr, values(), {.rollback = true}};
    run(task);
    is_left_alone(task);
    for (const std::size_t row : {0u, 1u}) EXPECT_EQ(states(task)[row], State::not_undone);
    for (const std::size_t row : {3u, 4u, 5u}) EXPECT_EQ(states(task)[row], State::waiting);
}

INSTANTIATE_TEST_SUITE_P(All, EachOther, testing::ValuesIn(others));

// The write that fails belongs to the previous device; the other one appears while the old values are written back.
TEST_F(Swapped, device_during_a_rollback_receives_no_further_old_value) {
    fake.parameters[4].store = [this](const Bytes&) { return fake.parameters[4].value; };
    after = 7;    // the third old value
    ParameterApply task{device, nullptr, values(), {.rollback = true}};
    run(task);
    EXPECT_TRUE(task.is_of_another());
    EXPECT_EQ(acted, std::vector<Bytes>{});
    EXPECT_EQ(states(task),
              (std::vector{State::not_undone, State::not_undone, State::undone, State::undone, State::failed, State::waiting}));
}

TEST_F(Swapped, device_that_does_not_answer_during_a_rollback_receives_no_old_value) {
    other.silent = 2500ms;
    ParameterApply task{device, nullptr, values(), {.rollback = true}};
    run(task);
    EXPECT_NE(task.end()->ending, Ending::done);
    EXPECT_EQ(acted, std::vector<Bytes>{});
}

TEST_F(Swapped, the_same_device_receives_the_value_again) {
    other.has_other_info = false;
    for (const bool down : {false, true}) {
        other.link_was_down = down;
        is_swapped = false;
        seen = 0;
        acted.clear();
        ParameterApply task{device, nullptr, values(), {.also_the_same = true}};
        run(task);
        EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
        EXPECT_EQ(acted.size(), 4u) << "the lost one, and those behind it";
        EXPECT_EQ(states(task), std::vector<State>(6, State::written));
    }
}

TEST_F(Swapped, a_device_that_writes_slowly_is_not_asked_for_its_info_after_each_value) {
    is_one = false;
    write_slowly();
    fake.parameters.clear();
    fake.make_parameters(40, 0);
    identify();
    std::vector<std::pair<std::string, AnyValue>> all;
    for (int i = 0; i < 40; ++i)
        if (i % 10 < 8) all.emplace_back("PAR_" + std::to_string(i), std::int64_t{70 + i % 7});
    all.resize(30);
    const TimePoint begin = simulation.now;
    questions = 0;
    ParameterApply import{device, nullptr, all, {.also_the_same = true}};
    run(import);
    EXPECT_EQ(import.end()->ending, Ending::done) << import.end()->fault.text();
    EXPECT_LE(simulation.now - begin, 17s);
    EXPECT_LE(questions, 5u);
}

TEST_F(Swapped, device_receives_no_second_save_or_reset) {
    at_id = 0xE0;
    after = 0;
    for (const Action what : {Action::save, Action::restore_defaults}) {
        ParameterAction task{device, what};
        run(task);
        is_left_alone(task);
        is_swapped = false;
        seen = 0;
        fake.name = "fake";
        fake.hardware = 100;
        identify();
    }
}

TEST_F(Swapped, device_receives_no_repeated_command) {
    at_id = 0xC0;
    after = 0;
    for (const Other& one :
         {Other{}, Other{.link_was_down = true}, Other{.link_was_down = true, .silent = 5s}, Other{.silent = 3s}}) {
        other = one;
        CommandCall task{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, true};
        run(task);
        is_left_alone(task);
        is_swapped = false;
        seen = 0;
        fake.name = "fake";
        fake.hardware = 100;
        identify();
    }
}

// It is not known whether the frames to the device or its answers are lost: the command may be LAND.
TEST_F(Swapped, a_silent_device_receives_the_command_again) {
    is_one = false;
    fake.deaf = true;
    fake.heard.clear();
    CommandCall task{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, true};
    run(task);
    EXPECT_EQ(std::count_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[3] == 0xC0; }), 5);
}

TEST_F(Swapped, device_receives_no_waypoint) {
    at_id = 0x61;
    for (const bool down : {false, true})
        for (const std::size_t at : {0u, 4u}) {
            after = at;
            other.link_was_down = down;
            std::vector<Waypoint> route;
            for (std::uint8_t i = 0; i < 10; ++i) route.push_back({i, 113.5, 22.25, 0, 0, 0, 0, {}});
            WaypointsPut task{device, route};
            run(task);
            is_left_alone(task);
            is_swapped = false;
            seen = 0;
            fake.name = "fake";
            fake.hardware = 100;
            fake.waypoints.clear();
            identify();
        }
}

TEST_F(Swapped, device_receives_no_frame_of_an_upgrade) {
    FakeLoader loader, of_other;
    at_id = 0xF0;
    after = 9;
    for (const bool down : {false, true}) {
        loader = of_other = {};
        other.link_was_down = down;
        other.silent = 500ms;
        before = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
            if (!is_swapped) return loader.take(fake, frame);
            return of_other.take(fake, frame);
        };
        FirmwareImage image;
        image.bytes = Bytes(3000);
        Firmware task{device, image};
        run(task);
        EXPECT_TRUE(task.is_of_another()) << task.end()->fault.text();
        EXPECT_EQ(of_other.infos + of_other.erases, 0u);
        EXPECT_EQ(task.end()->fault.text(),
                  "0xDC became another device in the meantime; the one before is left in its boot loader");
        is_swapped = false;
        seen = 0;
        fake.name = "fake";
        fake.hardware = 100;
        identify();
    }
}

TEST(AnotherDevice, is_not_cleared_and_receives_no_calibration) {
    for (const bool cancels : {true, false})
        for (const Duration silent : {300ms, 1000ms, 3000ms}) {
            support::CalibrationBench bench;
            ASSERT_TRUE(bench.run_to(Calibration::Step::turn, 3));
            bench.fake.name = "OTHER";
            const auto had = bench.flash = {1, 2, 3, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
            bench.actions.clear();
            bench.restart(silent);
            bench.run(silent + 100ms);
            if (cancels) bench.task.cancel(bench.now);
            bench.run();
            ASSERT_TRUE(bench.task.end());
            EXPECT_EQ(bench.actions, std::vector<std::uint16_t>{}) << cancels;
            EXPECT_EQ(bench.flash, had);
            EXPECT_FALSE(bench.task.has_old_values());
            EXPECT_NE(bench.task.end()->fault.text().find("0xDC became another device in the meantime"), std::string::npos)
                << bench.task.end()->fault.text();
        }
}

TEST(AnotherDevice, receives_no_old_values_when_the_new_ones_fail) {
    support::CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Calibration::Step::write));
    bench.run(100ms);
    ASSERT_EQ(bench.task.step(), Calibration::Step::write);
    bench.fake.name = "OTHER";
    const auto had = bench.flash = {1, 2, 3, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    bench.actions.clear();
    bench.restart(300ms);
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(bench.actions, std::vector<std::uint16_t>{});
    EXPECT_EQ(bench.flash, had);
    EXPECT_FALSE(bench.task.has_old_values());
}

// A device that was never asked for its device info.
struct Unasked : testing::Test {
    FakeDevice fake;
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = 10ms}};
    std::vector<std::uint8_t> ids() const {
        std::vector<std::uint8_t> all;
        for (const Bytes& one : fake.heard) all.push_back(one[3]);
        return all;
    }
};

TEST_F(Unasked, device_is_identified_before_the_first_frame_that_acts) {
    ParameterAction save{device, Action::save};
    std::size_t saves = 0;
    fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (intent_of(frame) != Intent::acts) return std::nullopt;
        ++saves;
        fake.name = "OTHER";
        return std::vector<Bytes>{};
    };
    save.start(simulation.now);
    simulation.run(save);
    ASSERT_TRUE(save.end());
    EXPECT_TRUE(save.is_of_another()) << save.end()->fault.text();
    EXPECT_EQ(saves, 1u);
    EXPECT_EQ(fake.heard.at(1)[3], 0xE0) << "who it is, before the save";
}

TEST_F(Unasked, device_that_never_sends_its_device_info_is_still_served) {
    fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
        const bool asks_who = frame.id() == 0xE0 && frame.data().size() >= 1 && frame.data()[0] == 0;
        return asks_who ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    const TimePoint begin = simulation.now;
    ParameterAction save{device, Action::save};
    save.start(simulation.now);
    simulation.run(save);
    EXPECT_EQ(save.end()->ending, Ending::done) << save.end()->fault.text();
    EXPECT_LE(simulation.now - begin, 1100ms);
    const TimePoint again = simulation.now;
    ParameterAction second{device, Action::save};
    second.start(simulation.now);
    simulation.run(second);
    EXPECT_EQ(second.end()->ending, Ending::done);
    EXPECT_LE(simulation.now - again, 100ms) << "it is asked once";
}

// Its other answers take 20 ms.
TEST(AnotherDevice, is_not_meant_by_device_info_that_arrives_late) {
    for (const Duration late : {1200ms, 1800ms, 2500ms})
        for (const bool is_measured : {false, true})
            for (const bool is_known : {false, true}) {
                SCOPED_TRACE(std::to_string(late / 1ms) + (is_measured ? " measured" : "") + (is_known ? " known" : ""));
                FakeDevice fake;
                fake.make_parameters(10);
                Device device{0xDC};
                Simulation simulation{device, fake, {.delay = 10ms}};
                const auto run = [&](auto& task) {
                    task.start(simulation.now);
                    simulation.run(task);
                    EXPECT_TRUE(task.end());
                };
                if (is_measured) {
                    Commands commands{device};
                    commands.read(simulation.now);
                    simulation.run(commands);
                }
                std::size_t lost = 0, questions = 0;
                fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
                    if (is_question_for_info(frame)) {
                        ++questions;
                        simulation.answer_later(fake.usual(frame).at(0), late);
                        return std::vector<Bytes>{};
                    }
                    if (intent_of(frame) == Intent::acts && lost++ == 0) return std::vector<Bytes>{};
                    return std::nullopt;
                };
                if (is_known) {
                    ParameterAction first{device, Action::save};
                    lost = 1;
                    run(first);
                    EXPECT_EQ(first.end()->ending, Ending::done) << first.end()->fault.text();
                    simulation.pass(5s);
                    ASSERT_TRUE(device.info());
                    lost = questions = 0;
                }
                ParameterAction save{device, Action::save};
                run(save);
                EXPECT_EQ(save.end()->ending, Ending::done) << save.end()->fault.text();
                EXPECT_EQ(lost, 2u);
                EXPECT_LE(questions, 8u);
            }
}

// It answers other questions at once, so the time of its answers is known.
TEST(AnotherDevice, device_info_of_a_device_that_is_received_may_take_3_s) {
    for (const Duration late : {1200ms, 1800ms, 2500ms}) {
        FakeDevice fake;
        fake.make_parameters(10);
        Device device{0xDC};
        Simulation simulation{device, fake, {.delay = 10ms}};
        Commands commands{device};
        commands.read(simulation.now);
        simulation.run(commands);
        std::size_t questions = 0;
        fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
            if (!is_question_for_info(frame)) return std::nullopt;
            ++questions;
            simulation.answer_later(fake.usual(frame).at(0), late);
            return std::vector<Bytes>{};
        };
        for (Duration at{}; at < 10s; at += 100ms) simulation.answer_later(support::frame(0xDC, 0xFF, 0x03, Bytes(7)), at);
        ParameterApply set{device, nullptr, {{"PAR_1", AnyValue{std::int64_t{5}}}}};
        set.start(simulation.now);
        simulation.run(set);
        ASSERT_TRUE(set.end());
        EXPECT_EQ(set.end()->ending, Ending::done) << set.end()->fault.text();
        EXPECT_LE(questions, 14u);
    }
}

TEST(AnotherDevice, the_missing_device_info_is_reported_without_a_guess) {
    for (const bool is_received : {false, true})
        for (const bool answers : {false, true}) {
            SCOPED_TRACE(std::to_string(is_received) + std::to_string(answers));
            FakeDevice fake;
            Device device{0xDC};
            Simulation simulation{device, fake, {.delay = 10ms}};
            if (answers) {
                Commands commands{device};
                commands.read(simulation.now);
                simulation.run(commands);
            }
            fake.deaf = true;
            const TimePoint begin = simulation.now;
            for (Duration at{}; is_received && at < 10s; at += 100ms)
                simulation.answer_later(support::frame(0xDC, 0xFF, 0x03, Bytes(7)), at);
            Parameters list{device};
            list.read_all(simulation.now);
            simulation.run(list);
            ASSERT_TRUE(list.end());
            EXPECT_EQ(list.end()->ending, Ending::timeout);
            const std::string& what = list.end()->fault.text();
            EXPECT_EQ(what.find("frames to it may not arrive") != std::string::npos, is_received && !answers) << what;
            EXPECT_EQ(what.find("it has answered other requests") != std::string::npos, is_received && answers) << what;
            const Duration took = simulation.now - begin;
            EXPECT_LE(took, !answers ? 6200ms : is_received ? 3700ms : 1200ms);
        }
}

// Its version is a counter.
struct Varying : Swapped {
    Varying() {
        is_one = false;
        before = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
            if (is_question_for_info(frame) && varies) ++fake.version;
            if (intent_of(frame) != Intent::acts || ++acts % 2 == 0) return std::nullopt;
            if (other.link_was_down) device.link_was_down();
            return std::vector<Bytes>{};    // each second one is lost
        };
        for (int i = 0; i < 3; ++i) identify();
    }
    bool varies = true;
    std::size_t acts = 0;
};

TEST_F(Varying, device_info_shows_no_other_device) {
    EXPECT_TRUE(device.has_varying_info());
    for (const bool down : {false, true}) {
        other.link_was_down = down;
        ParameterApply import{device, nullptr, values(), {.also_the_same = true}};
        run(import);
        EXPECT_EQ(import.end()->ending, Ending::done) << import.end()->fault.text();
        ParameterAction save{device, Action::save};
        run(save);
        EXPECT_EQ(save.end()->ending, Ending::done) << save.end()->fault.text();
    }
    acts = 0;
    CommandCall call{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, true};
    run(call);
    EXPECT_NE(call.end()->ending, Ending::done) << "the link was down, and nothing shows who answers";
    EXPECT_EQ(acts, 1u);
}

// Only its version is a counter. The board that replaces it has another name and other hardware.
TEST_F(Varying, device_info_shows_another_device_by_a_field_that_does_not_vary) {
    for (const bool is_announced : {false, true})
        for (const bool down : {false, true}) {
            SCOPED_TRACE(std::to_string(is_announced) + std::to_string(down));
            other.is_announced = is_announced;
            other.link_was_down = down;
            is_swapped = false;
            seen = 0;
            fake.name = "fake";
            fake.hardware = 100;
            before = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
                if (is_question_for_info(frame)) ++fake.version;
                return std::nullopt;
            };
            for (int i = 0; i < 3; ++i) identify();
            ASSERT_TRUE(device.has_varying_info());
            is_one = true;
            ParameterApply import{device, nullptr, values(), {.also_the_same = true}};
            run(import);
            is_left_alone(import);
        }
}

TEST_F(Varying, device_is_not_upgraded_in_place_of_another_one) {
    FakeLoader loader, of_other;
    is_one = true;
    at_id = 0xF0;
    after = 9;
    other.silent = 500ms;
    before = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (is_question_for_info(frame)) ++fake.version;
        return is_swapped ? of_other.take(fake, frame) : loader.take(fake, frame);
    };
    FirmwareImage image;
    image.bytes = Bytes(3000);
    Firmware task{device, image};
    run(task);
    EXPECT_TRUE(task.is_of_another()) << task.end()->fault.text();
    EXPECT_EQ(of_other.infos + of_other.erases, 0u);
}

// Its telemetry begins with the operation: there may have been a pause before.
TEST(AnotherDevice, is_not_meant_by_a_counter_in_the_device_info_behind_a_line_that_loses_frames) {
    for (const int reads : {0, 1, 2})
        for (std::uint64_t seed = 1; seed <= 40; ++seed) {
            SCOPED_TRACE(std::to_string(reads) + " reads, seed " + std::to_string(seed));
            FakeDevice fake;
            fake.make_parameters(10);
            Device device{0xDC};
            Simulation simulation{device, fake, {.delay = 10ms, .loss = 0.05}, seed};
            fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
                if (is_question_for_info(frame)) ++fake.version;
                return std::nullopt;
            };
            for (int i = 0; i < reads; ++i) {
                Parameters parameters{device};
                parameters.read(Parameters::Values::none, simulation.now);
                simulation.run(parameters);
            }
            simulation.pass(1s);
            for (Duration at{}; at < 60s; at += 50ms) simulation.answer_later(support::frame(0xDC, 0xFF, 0x03, Bytes(7)), at);
            std::vector<Waypoint> route;
            for (std::uint8_t i = 0; i < 30; ++i) route.push_back({i, 113.5, 22.25, 0, 0, 0, 0, {}});
            WaypointsPut put{device, route};
            put.mean_present_device();
            put.start(simulation.now);
            simulation.run(put);
            ASSERT_TRUE(put.end());
            EXPECT_EQ(put.end()->ending, Ending::done) << put.end()->fault.text();
        }
}

// The second difference in a row without a sign shows that it varies, and no other device.
TEST(AnotherDevice, is_not_meant_by_the_second_of_two_differences_without_a_sign) {
    FakeDevice fake;
    fake.make_parameters(3);
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = 10ms}};
    std::vector<std::uint32_t> identities;
    for (const std::uint16_t version : std::initializer_list<std::uint16_t>{1, 2, 3, 4}) {
        fake.version = version;
        Parameters parameters{device};
        parameters.read(Parameters::Values::none, simulation.now);
        simulation.run(parameters);
        identities.push_back(device.identity().device);
    }
    EXPECT_EQ(identities, (std::vector<std::uint32_t>{0, 1, 1, 1}));
}

TEST_F(Varying, device_info_that_becomes_constant_shows_another_device_again) {
    varies = false;
    for (int i = 0; i < 3; ++i) identify();
    EXPECT_FALSE(device.has_varying_info());
    acts = 0;
    ParameterAction save{device, Action::save};
    fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (intent_of(frame) != Intent::acts) return std::nullopt;
        ++acts;
        fake.name = "OTHER";
        return std::vector<Bytes>{};
    };
    run(save);
    EXPECT_TRUE(save.is_of_another()) << save.end()->fault.text();
    EXPECT_EQ(acts, 1u);
}

TEST_F(Swapped, a_device_whose_info_varies_gets_a_command_after_each_sign) {
    is_one = false;
    before = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (is_question_for_info(frame)) ++fake.version;
        if (frame.id() == 0xC0) acted.emplace_back(frame.bytes().begin(), frame.bytes().end());
        return std::nullopt;
    };
    for (std::size_t i = 1; i <= 4; ++i) {
        CommandCall land{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, false};
        device.link_was_down();
        run(land);
        EXPECT_EQ(land.end()->ending, Ending::done) << i << land.end()->fault.text();
        EXPECT_EQ(acted.size(), i);
        ParameterAction save{device, Action::save};
        device.link_was_down();
        run(save);
        EXPECT_EQ(save.end()->ending, Ending::done) << i << save.end()->fault.text();
    }
}

// The first answer differs, and the second one is lost.
TEST_F(Swapped, another_device_that_answers_once_gets_no_command) {
    is_one = false;
    CommandCall land{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, false};
    device.link_was_down();
    fake.name = "OTHER";
    before = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (is_question_for_info(frame) && questions++ > 0) return std::vector<Bytes>{};
        if (frame.id() == 0xC0) acted.emplace_back(frame.bytes().begin(), frame.bytes().end());
        return std::nullopt;
    };
    run(land);
    EXPECT_TRUE(land.is_of_another());
    EXPECT_EQ(acted, std::vector<Bytes>{});
}

TEST_F(Swapped, a_device_that_does_not_answer_the_info_request_gets_a_command_after_half_a_second) {
    is_one = false;
    std::optional<TimePoint> sent_at;
    before = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (is_question_for_info(frame)) return ++questions, std::vector<Bytes>{};
        if (frame.id() == 0xC0 && !sent_at) sent_at = simulation.now;
        return std::nullopt;
    };
    simulation.pass(5s);
    device.link_was_down();
    const TimePoint asked_at = simulation.now;
    CommandCall land{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, false};
    run(land);
    ASSERT_TRUE(sent_at);
    EXPECT_LE(*sent_at - asked_at, 600ms);
    EXPECT_LE(questions, Device::sends_before_command);
}

// It is for the device that is present.
TEST_F(Swapped, a_command_by_its_bytes_is_the_first_frame_after_each_sign) {
    is_one = false;
    const auto frames_of = [&](bool repeats) {
        fake.heard.clear();
        CommandCall land{device, {0, {16, 0, 2}, {}, false, ""}, {}, repeats};
        land.mean_present_device();
        run(land);
        EXPECT_EQ(land.end()->ending, Ending::done) << land.end()->fault.text();
        return fake.heard;
    };
    for (const bool repeats : {false, true})
        for (const bool is_other : {false, true}) {
            SCOPED_TRACE(std::to_string(repeats) + std::to_string(is_other));
            fake.name = is_other ? "OTHER" : "fake";
            device.link_was_down();
            const auto heard = frames_of(repeats);
            ASSERT_EQ(heard.size(), 1u);
            EXPECT_EQ(heard[0][3], 0xC0);
        }
}

TEST_F(Swapped, a_repeated_command_by_its_bytes_is_not_sent_to_another_device) {
    at_id = 0xC0;
    after = 0;
    for (const bool down : {false, true}) {
        other.link_was_down = down;
        device.link_was_down();
        CommandCall task{device, {0, {16, 0, 2}, {}, false, ""}, {}, true};
        task.mean_present_device();
        run(task);
        is_left_alone(task);
        is_swapped = false;
        seen = 0;
        fake.name = "fake";
        fake.hardware = 100;
        identify();
    }
}

TEST_F(Swapped, a_command_by_its_bytes_passes_requests_that_wait_for_the_device_info) {
    is_one = false;
    device.link_was_down();
    ParameterAction save{device, Action::save};
    CommandCall by_name{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, false};
    CommandCall by_bytes{device, {0, {16, 0, 3}, {}, false, ""}, {}, false};
    by_bytes.mean_present_device();
    save.start(simulation.now);
    by_name.start(simulation.now);
    by_bytes.start(simulation.now);
    const auto first = device.next_frame(simulation.now);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->id(), 0xC0);
    EXPECT_EQ(first->data()[2], 3);
}

TEST(AnotherDevice, is_meant_by_one_device_info_that_differs) {
    FakeDevice fake;
    fake.make_parameters(3);
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = 10ms}};
    for (const std::uint16_t version : std::initializer_list<std::uint16_t>{1, 1, 2, 2}) {
        fake.version = version;
        Parameters parameters{device};
        parameters.read(Parameters::Values::none, simulation.now);
        simulation.run(parameters);
        EXPECT_FALSE(device.has_varying_info());
    }
}

TEST_F(Unasked, device_receives_a_command_as_its_first_frame_and_no_repeat_after_its_link_was_down) {
    CommandCall call{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, true};
    fake.instead = [&](FrameView) -> std::optional<std::vector<Bytes>> {
        device.link_was_down();
        return std::vector<Bytes>{};
    };
    call.start(simulation.now);
    simulation.run(call);
    ASSERT_TRUE(call.end());
    EXPECT_EQ(ids(), std::vector<std::uint8_t>{0xC0});
}

TEST_F(Unasked, device_that_announces_itself_gets_no_repeat) {
    CommandCall call{device, {0, {16, 0, 2}, {}, false, "LAND"}, {}, true};
    call.mean_present_device();
    fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (frame.id() != 0xC0) return std::nullopt;
        simulation.answer_later(fake.usual(FrameView{support::frame(0xFE, 0xDC, 0xE0, {0, 0, 0})}).at(0), 500ms);
        return std::vector<Bytes>{};
    };
    call.start(simulation.now);
    simulation.run(call);
    ASSERT_TRUE(call.end());
    EXPECT_NE(call.end()->ending, Ending::done);
    EXPECT_EQ(ids(), std::vector<std::uint8_t>{0xC0});
}

}    // namespace
}    // namespace ano::host::another_device_tests
