// A calibration from the old values to the new ones, and the restoring of the old ones after a failure.
#include <host/calibration.hpp>

#include <support/fake_device.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace ano::host::calibration_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using support::FakeDevice;
using support::Simulation;

Bytes f32(double value) {
    Bytes bytes(4);
    store(bytes.data(), static_cast<float>(value));
    return bytes;
}

struct Calibrates : testing::Test {
    FakeDevice fake;
    Device device{0xDC};
    DescriptionCache cache;
    Simulation simulation{device, fake, {.delay = 10ms}};
    std::vector<Bytes> old;
    std::vector<std::uint16_t> actions;
    bool forgets_once = false;    // one of the values, when it applies them
    bool shows_the_clear = true;
    Calibration::Step step = Calibration::Step::read;    // at the last sample
    Duration pace = 20ms;

    void make(Sensor sensor) {
        fake.parameters = {{0, "FIRST", "", {1}}};
        double value = 0.5;
        for (const std::string& name : calibration_names(sensor)) fake.parameters.push_back({8, name, "", f32(value += 0.125)});
        fake.parameters.push_back({0, "LAST", "", {1}});
        old = stored();
        fake.instead = [&, sensor](FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() == 0xE0 && f.data()[0] == 0x10) actions.push_back(load<std::uint16_t>(f.data().data() + 1));
            const bool clears = f.id() == 0xE0 && f.data()[0] == 0x10 && f.data()[1] % 0x10 == 0;
            if (clears && shows_the_clear) store(neutral_calibration(sensor));
            if (!actions.empty() && actions.back() == 0x21 && std::exchange(forgets_once, false))
                fake.parameters[2].value = f32(9);
            return std::nullopt;
        };
    }
    void store(const CalibrationValues& values) {
        for (std::size_t i = 0; i < values.size(); ++i) fake.parameters[1 + i].value = f32(std::get<double>(values[i].second));
    }
    std::vector<Bytes> stored() const {
        std::vector<Bytes> all;
        for (const auto& p : fake.parameters)
            if (p.type == 8) all.push_back(p.value);
        return all;
    }
    void begin(Calibration& task) {
        task.start(simulation.now);
        simulation.run(task);
        ASSERT_EQ(task.step(), Calibration::Step::keep) << (task.end() ? task.end()->fault.text() : "");
        EXPECT_TRUE(actions.empty()) << "nothing is changed before the old values are kept";
        task.kept(simulation.now);
        simulation.run(task);
        ASSERT_EQ(task.step(), Calibration::Step::turn);
    }
    void lie(Calibration& task, std::size_t face, int offset = 20) {
        Draft<"inertial"> m;
        std::array<int, 3> acc{offset, 0, 0};
        acc[face / 2] += face % 2 == 0 ? 1000 : -1000;
        for (int i = 0; i < 100; ++i) {
            (void)m.set<"acc_x">(acc[0] + i % 3);
            (void)m.set<"acc_y">(acc[1] - i % 3);
            (void)m.set<"acc_z">(acc[2] + i % 2);
            receive(task, m);
        }
    }
    // Samples count only after the time in which samples from before can arrive.
    template <class Message>
    void receive(Calibration& task, const Message& message) {
        const bool measures = task.step() == Calibration::Step::turn || task.step() == Calibration::Step::verify;
        if (std::exchange(step, task.step()) != task.step() && measures)
            for (const TimePoint end = simulation.now + Calibration::most_late; simulation.now < end;)
                receive_once(task, message);
        receive_once(task, message);
    }
    template <class Message>
    void receive_once(Calibration& task, const Message& message) {
        std::array<std::uint8_t, 64> bytes{};
        const std::size_t size = message.encode(bytes, 0xDC, 0xFF);
        simulation.pass(pace);
        device.take(FrameView{std::span{bytes}.first(size)}, simulation.now);
        task.receive(FrameView{std::span{bytes}.first(size)}, simulation.now);
    }
    // The device is turned to all sides and its new values are stored; it lies on the last face, and uses them.
    void turn(Calibration& task) {
        for (std::size_t face = 0; face < 6; ++face) lie(task, face);
        simulation.run(task);
        if (task.step() != Calibration::Step::verify) return;
        Draft<"inertial"> m;
        (void)m.set<"acc_z">(-981);
        for (int i = 0; i < 120; ++i) receive(task, m);
        simulation.run(task);
    }
};

TEST_F(Calibrates, an_accelerometer) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    EXPECT_EQ(task.old_values().size(), 15u);
    EXPECT_EQ(task.old_values()[14].first, "CAL_AEM3_Z");
    for (std::size_t face = 0; face < 6; ++face) {
        lie(task, face);
        EXPECT_EQ(task.progress().done, face + 1);
    }
    simulation.run(task);
    EXPECT_EQ(task.step(), Calibration::Step::verify);
    EXPECT_EQ(task.face_to_verify(), Face::z_minus);
    Draft<"inertial"> m;
    (void)m.set<"acc_z">(-981);
    for (int i = 0; i < 120; ++i) receive(task, m);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
    EXPECT_EQ(actions, (std::vector<std::uint16_t>{0x20, 0x21}));
    ASSERT_TRUE(task.residuals());
    EXPECT_LT(task.residuals()->second, task.residuals()->first);
    const auto now = stored();
    EXPECT_NEAR(load<float>(now[0].data()), 21, 1);             // offset of x
    EXPECT_NEAR(load<float>(now[3].data()), 0.980665, 1e-3);    // sensitivity
    EXPECT_NEAR(load<float>(now[6].data()), 1, 1e-3);           // error matrix
    EXPECT_EQ(fake.parameters.front().value, Bytes{1});
    EXPECT_EQ(fake.parameters.back().value, Bytes{1});
}

// As over a radio that sends answers first: samples from before the clear, and from before the store, arrive up to 3 s later.
TEST_F(Calibrates, without_samples_that_may_be_older_than_the_clear_or_the_store) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    step = task.step();
    const auto lies_for = [&](ano::Duration time, int z) {
        Draft<"inertial"> m;
        (void)m.set<"acc_z">(static_cast<std::int16_t>(z));
        for (const TimePoint end = simulation.now + time; simulation.now < end;) receive(task, m);
    };
    lies_for(2900ms, 981);
    EXPECT_EQ(task.progress().done, 0u);
    lies_for(2s, 981);
    EXPECT_EQ(task.progress().done, 1u);
    for (std::size_t face = 0; face < 6; ++face) lie(task, face);
    simulation.run(task);
    ASSERT_EQ(task.step(), Calibration::Step::verify);
    step = task.step();
    lies_for(2900ms, -981);
    EXPECT_FALSE(task.verified());
}

TEST_F(Calibrates, a_compass) {
    make(Sensor::compass);
    Calibration task{device, Sensor::compass, &cache};
    begin(task);
    Draft<"compass"> m;
    for (int i = 0; i < 3000 && task.step() == Calibration::Step::turn; ++i) {
        const double z = 2 * (i % 100 + 0.5) / 100 - 1, around = i * 2.4;
        (void)m.set<"mag_x">(std::round(500 * std::sqrt(1 - z * z) * std::cos(around) + 100));
        (void)m.set<"mag_y">(std::round(400 * std::sqrt(1 - z * z) * std::sin(around) - 50));
        (void)m.set<"mag_z">(std::round(450 * z));
        receive(task, m);
    }
    simulation.run(task);
    ASSERT_EQ(task.step(), Calibration::Step::verify);
    for (int i = 0; i < 30; ++i) {    // corrected
        (void)m.set<"mag_x">(std::round(448 * std::cos(i * 0.5)));
        (void)m.set<"mag_y">(std::round(448 * std::sin(i * 0.5)));
        (void)m.set<"mag_z">(0);
        receive(task, m);
    }
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
    EXPECT_LT(task.verified().value_or(1), 0.02);
    EXPECT_EQ(actions, (std::vector<std::uint16_t>{0x30, 0x31}));
    EXPECT_NEAR(load<float>(stored()[0].data()), 100, 2);
    EXPECT_NEAR(load<float>(stored()[1].data()), -50, 2);
    EXPECT_NEAR(load<float>(stored()[3].data()), 448.1 / 500, 0.01);
}

TEST_F(Calibrates, a_compass_again_when_the_device_restarts_directly_after_the_clear) {
    make(Sensor::compass);
    Calibration task{device, Sensor::compass, &cache};
    begin(task);
    simulation.pass(700ms);
    Draft<"compass"> m;
    (void)m.set<"mag_x">(500);
    for (int i = 0; i < 3; ++i) receive(task, m);
    EXPECT_EQ(task.restarts(), 1u);
    simulation.run(task);
    EXPECT_EQ(task.step(), Calibration::Step::turn);
    EXPECT_EQ(actions, (std::vector<std::uint16_t>{0x30, 0x30}));
}

TEST_F(Calibrates, a_compass_again_when_its_samples_were_corrected_already) {
    make(Sensor::compass);
    Calibration task{device, Sensor::compass, &cache};
    begin(task);
    Draft<"compass"> m;
    for (int i = 0; i < 3000 && task.step() == Calibration::Step::turn; ++i) {
        const double z = 2 * (i % 100 + 0.5) / 100 - 1, around = i * 2.4;
        (void)m.set<"mag_x">(std::round(500 * std::sqrt(1 - z * z) * std::cos(around)));
        (void)m.set<"mag_y">(std::round(500 * std::sqrt(1 - z * z) * std::sin(around)));
        (void)m.set<"mag_z">(std::round(500 * z));
        receive(task, m);
    }
    simulation.run(task);
    EXPECT_EQ(task.step(), Calibration::Step::turn);
    EXPECT_EQ(task.last_restart().text(), "its samples were already corrected");
    EXPECT_FALSE(task.residuals());
    EXPECT_EQ(actions, (std::vector<std::uint16_t>{0x30, 0x30}));
}

// Its parameters never show the clear, and during the turning it starts to use its old calibration again.
struct HidesTheClear : Calibrates {
    static constexpr CompassCalibration right{{110, -70, 55}, {1.02, 0.97, 1}};

    // A sample of direction `i`; the device has corrected it by `used`.
    void receive_field(Calibration& task, int i, const CompassCalibration& used) {
        const double z = 2 * (i % 100 + 0.5) / 100 - 1, around = i * 2.4;
        const Vector v = used.corrected(right.raw_of(
            {500 * std::sqrt(1 - z * z) * std::cos(around), 500 * std::sqrt(1 - z * z) * std::sin(around), 500 * z}));
        Draft<"compass"> m;
        (void)m.set<"mag_x">(std::round(v[0]));
        (void)m.set<"mag_y">(std::round(v[1]));
        (void)m.set<"mag_z">(std::round(v[2]));
        receive(task, m);
    }
    CompassCalibration in_use() const {
        std::array<float, 6> values{};
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = load<float>(stored()[i].data());
        return CompassCalibration::of(values);
    }
    // Sends raw samples first, then samples that it corrects with `old_one`.
    void calibrate(Calibration& task, int raw_ones, const CompassCalibration& old_one) {
        make(Sensor::compass);
        shows_the_clear = false;
        pace = 10ms;
        const auto values = old_one.values();
        for (std::size_t i = 0; i < values.size(); ++i) fake.parameters[1 + i].value = f32(values[i]);
        old = stored();
        begin(task);
        for (int i = 0; i < 12000 && !task.end() && task.step() <= Calibration::Step::prove; ++i) {
            task.look(simulation.now);
            const bool turns = task.step() == Calibration::Step::turn;
            if (task.step() == Calibration::Step::confirm || task.step() == Calibration::Step::write) simulation.run(task);
            receive_field(task, i, !turns ? in_use() : i < raw_ones ? CompassCalibration{} : old_one);
        }
        simulation.run(task);
        ASSERT_TRUE(task.end());
    }
};

TEST_F(HidesTheClear, a_compass_is_verified_on_all_sides) {
    Calibration task{device, Sensor::compass, &cache};
    calibrate(task, 6000, {{60, -40, 30}, {1, 1, 1}});
    EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
    EXPECT_NEAR(in_use().offset[0], 110, 2);
    EXPECT_LT(task.verified().value_or(1), 0.005);
}

TEST_F(HidesTheClear, a_compass_is_never_calibrated_worse_than_before) {
    for (const CompassCalibration& old_one :
         {CompassCalibration{{115, -76, 58}, {1, 0.98, 0.99}}, right, CompassCalibration{{60, -40, 30}, {1, 1, 1}}})
        for (const int raw_ones : {0, 50, 100, 150, 190}) {
            simulation.now += 1min;
            actions.clear();
            Calibration task{device, Sensor::compass, nullptr};
            calibrate(task, raw_ones, old_one);
            if (task.end()->ending == Ending::done) {
                EXPECT_NEAR(in_use().offset[0], 110, 5) << raw_ones;
            } else {
                EXPECT_EQ(stored(), old) << task.end()->fault.text();
            }
        }
}

// The slower the line, the later a question times out.
struct CalibratesSlowly : Calibrates, testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(Delays, CalibratesSlowly, testing::Values(1, 10, 20, 30, 40, 60, 100, 200));

TEST_P(CalibratesSlowly, a_compass_and_reports_within_five_seconds_that_it_was_lost_at_the_first_value) {
    simulation.there.delay = simulation.back.delay = std::chrono::milliseconds{GetParam()};
    make(Sensor::compass);
    Calibration task{device, Sensor::compass, &cache};
    begin(task);
    Draft<"compass"> m;
    for (int i = 0; i < 3000 && task.step() == Calibration::Step::turn; ++i) {
        const double z = 2 * (i % 100 + 0.5) / 100 - 1, around = i * 2.4;
        (void)m.set<"mag_x">(std::round(500 * std::sqrt(1 - z * z) * std::cos(around) + 100));
        (void)m.set<"mag_y">(std::round(400 * std::sqrt(1 - z * z) * std::sin(around) - 50));
        (void)m.set<"mag_z">(std::round(450 * z));
        receive(task, m);
    }
    ASSERT_EQ(task.step(), Calibration::Step::confirm);
    fake.deaf = true;
    const TimePoint died = simulation.now;
    simulation.each_step = [&](TimePoint now) {
        if (const auto at = task.due(); at && now >= *at) task.look(now);
    };
    while (!task.end() && simulation.now < died + 10s) {
        simulation.run(task, 20ms);
        simulation.now = std::min(task.due().value_or(simulation.now), simulation.now + 20ms);
        task.look(simulation.now);
    }
    ASSERT_TRUE(task.end());
    EXPECT_LE(simulation.now - died, 4950ms);
}

TEST_F(Calibrates, and_writes_nothing_before_the_new_values_are_saved) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    task.keep_before_writing();
    begin(task);
    for (std::size_t face = 0; face < 6; ++face) lie(task, face);
    simulation.run(task);
    ASSERT_EQ(task.step(), Calibration::Step::keep_new);
    EXPECT_EQ(task.new_values().size(), 15u);
    EXPECT_EQ(load<float>(stored()[0].data()), 0);
    EXPECT_EQ(task.cleared_values().size(), 15u);
    task.kept(simulation.now);
    simulation.run(task);
    EXPECT_EQ(task.step(), Calibration::Step::verify);
}

TEST_F(Calibrates, and_writes_no_values_that_could_not_be_saved) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    task.keep_before_writing();
    begin(task);
    for (std::size_t face = 0; face < 6; ++face) lie(task, face);
    simulation.run(task);
    ASSERT_EQ(task.step(), Calibration::Step::keep_new);
    task.not_kept("the disk is full", simulation.now);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->fault.text(),
              "the new values were not written, because they could not be saved: the disk is full; the old values are restored");
    EXPECT_EQ(stored(), old);
}

TEST_F(Calibrates, and_restores_the_old_values_when_the_result_is_rejected) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    for (std::size_t face = 0; face < 6; ++face) lie(task, face, face % 2 == 0 ? 380 : -380);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::failed);
    EXPECT_NE(task.end()->fault.text().find("; the old values are restored"), std::string::npos) << task.end()->fault.text();
    EXPECT_EQ(stored(), old);
    EXPECT_EQ(actions, (std::vector<std::uint16_t>{0x20, 0x21}));
}

TEST_F(Calibrates, and_restores_the_old_values_after_it_is_cancelled) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    for (auto& p : fake.parameters)
        if (p.type == 8) p.value = f32(0);
    task.cancel(simulation.now);
    EXPECT_FALSE(task.end());
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::cancelled);
    EXPECT_EQ(stored(), old);
}

// A device that was never calibrated may store any bytes there, such as erased flash.
TEST_F(Calibrates, and_restores_old_values_that_are_not_numbers_bit_for_bit) {
    make(Sensor::accelerometer);
    fake.parameters[1].value = {0xFF, 0xFF, 0xFF, 0xFF};
    fake.parameters[2].value = {0x01, 0x00, 0x80, 0x7F};    // a signalling NaN
    fake.parameters[3].value = {0x00, 0x00, 0x80, 0xFF};    // -inf
    old = stored();
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    for (auto& p : fake.parameters)
        if (p.type == 8) p.value = f32(0);
    task.cancel(simulation.now);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->fault.text(), "cancelled; the old values are restored");
    EXPECT_TRUE(task.has_old_values());
    EXPECT_EQ(stored(), old);
}

TEST_F(Calibrates, a_device_whose_old_value_is_not_a_number) {
    make(Sensor::accelerometer);
    fake.parameters[1].value = {0xFF, 0xFF, 0xFF, 0xFF};
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    turn(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
}

TEST_F(Calibrates, and_restores_the_old_values_of_a_device_that_limits_the_new_ones) {
    make(Sensor::accelerometer);
    fake.parameters[1].store = [](const Bytes& value) { return load<float>(value.data()) > 20 ? f32(20) : value; };
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    turn(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::refused);
    EXPECT_EQ(task.end()->fault.text(), "CAL_AOFF_X is 20: the device limited it; the old values are restored");
    EXPECT_EQ(stored(), old);
}

// As one with protocol V7 does. Some of the new values then equal the cleared ones.
TEST_F(Calibrates, a_device_that_stores_thousandths) {
    make(Sensor::accelerometer);
    for (auto& parameter : fake.parameters)
        if (parameter.type == 8)
            parameter.store = [](const Bytes& value) { return f32(std::round(1000.0 * load<float>(value.data())) / 1000); };
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    turn(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
    const auto has = stored();
    for (std::size_t i = 0; i < has.size(); ++i) EXPECT_EQ(f32(std::get<double>(task.new_values()[i].second)), has[i]) << i;
    EXPECT_NE(has, old);
}

TEST_F(Calibrates, and_restores_the_old_values_of_a_device_that_does_not_store_the_new_ones) {
    make(Sensor::accelerometer);
    forgets_once = true;
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    turn(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::refused);
    EXPECT_EQ(task.end()->fault.text(), "0xDC does not keep CAL_AOFF_Y; the old values are restored");
    EXPECT_EQ(stored(), old);
}

TEST_F(Calibrates, and_ends_after_ten_minutes_if_the_device_is_not_turned) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    ASSERT_TRUE(task.due());
    const TimePoint begin = simulation.now;
    while (task.step() == Calibration::Step::turn && simulation.now - begin < 11min) {
        lie(task, 0);
        task.look(simulation.now);
    }
    EXPECT_NEAR(std::chrono::duration<double>(simulation.now - begin).count(), 600, 2);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::timeout);
    EXPECT_EQ(stored(), old);
}

TEST_F(Calibrates, and_reports_that_the_old_values_of_a_lost_device_are_not_restored) {
    make(Sensor::accelerometer);
    Calibration task{device, Sensor::accelerometer, &cache};
    begin(task);
    fake.deaf = true;
    task.cancel(simulation.now);
    EXPECT_LT(simulation.run(task), 1min);
    ASSERT_TRUE(task.end());
    EXPECT_NE(task.end()->fault.text().find("could not be written back"), std::string::npos) << task.end()->fault.text();
    fake.deaf = false;
    CalibrationWrite later{device, &cache, Sensor::accelerometer, task.old_values()};
    later.start(simulation.now);
    simulation.run(later);
    ASSERT_TRUE(later.end());
    EXPECT_EQ(later.end()->ending, Ending::done) << later.end()->fault.text();
}

TEST_F(Calibrates, nothing_when_the_parameters_are_missing_or_in_the_wrong_order) {
    make(Sensor::accelerometer);
    std::swap(fake.parameters[3].name, fake.parameters[4].name);
    Calibration order{device, Sensor::accelerometer, nullptr};
    order.start(simulation.now);
    simulation.run(order);
    ASSERT_TRUE(order.end());
    EXPECT_EQ(order.end()->ending, Ending::unsupported);
    Calibration none{device, Sensor::compass, nullptr};
    none.start(simulation.now);
    simulation.run(none);
    ASSERT_TRUE(none.end());
    EXPECT_EQ(none.end()->ending, Ending::unsupported);
    EXPECT_TRUE(actions.empty());
}

}    // namespace
}    // namespace ano::host::calibration_tests
