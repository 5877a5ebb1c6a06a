// A device that restarts, fails or does not use the stored values during its calibration.
#include <support/calibrated_device.hpp>
#include <support/sanitized.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

namespace ano::host::calibration_restarts_tests {
namespace {

using namespace std::chrono_literals;
using support::CalibrationBench;
using Step = Calibration::Step;

std::ptrdiff_t clears(const CalibrationBench& bench) { return std::count(bench.actions.begin(), bench.actions.end(), 0x20); }

void is_calibrated(CalibrationBench& bench) {
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(bench.task.end()->ending, Ending::done) << bench.task.end()->fault.text();
    EXPECT_LT(bench.worst_face(), 2);
    EXPECT_LE(bench.task.verified().value_or(1000), 4 + 3 * bench.task.residuals()->second);
}

TEST(CalibrationRestarts, without_any_the_device_is_cleared_once) {
    CalibrationBench bench;
    EXPECT_GT(bench.worst_face(), 50);
    is_calibrated(bench);
    EXPECT_EQ(bench.actions, (std::vector<std::uint16_t>{0x20, 0x21}));
    EXPECT_EQ(bench.task.restarts(), 0u);
}

// The version in its device info counts up in each answer, and nothing was asked before.
TEST(CalibrationRestarts, are_not_meant_by_a_counter_in_the_device_info) {
    CalibrationBench bench;
    bench.fake.instead = [&, usual = bench.fake.instead](FrameView frame) {
        if (is_question_for_info(frame)) ++bench.fake.version;
        return usual(frame);
    };
    is_calibrated(bench);
    EXPECT_EQ(bench.actions, (std::vector<std::uint16_t>{0x20, 0x21}));
    EXPECT_EQ(bench.task.restarts(), 0u);
}

TEST(CalibrationRestarts, an_older_device_is_calibrated_by_scaled_values) {
    CalibrationBench bench;
    bench.make_scaled(100'000);
    ASSERT_TRUE(bench.run_to(Step::turn, 3));
    bench.restart(0s);
    is_calibrated(bench);
    EXPECT_EQ(bench.task.restarts(), 1u);
}

TEST(CalibrationRestarts, the_scaled_old_values_of_an_older_device_are_restored) {
    CalibrationBench bench;
    bench.make_scaled(100'000);
    const auto old = bench.flash;
    bench.uses_nothing = true;
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_TRUE(bench.task.has_old_values()) << bench.task.end()->fault.text();
    EXPECT_EQ(bench.flash, old);
}

// Its sensitivities are stored in tenths: the rounding error exceeds the residual of the fit.
TEST(CalibrationRestarts, an_older_device_with_a_coarse_scale_keeps_its_old_values) {
    CalibrationBench bench;
    bench.flash = {-30, 20, 10, 0.9f, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    bench.make_scaled(10);
    const auto old = bench.flash;
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(bench.task.end()->fault.text(),
              "rejected: the device can't store the new values precisely enough; the old values are restored");
    EXPECT_GT(bench.task.residuals()->second, 5);
    EXPECT_LT(bench.task.residuals()->second, SixFaces::max_residual) << "it may be below that";
    EXPECT_EQ(bench.flash, old);
}

TEST(CalibrationRestarts, that_only_the_values_show_are_detected_before_the_fit) {
    CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Step::turn, 3));
    bench.restart(0s);
    is_calibrated(bench);
    EXPECT_EQ(bench.task.restarts(), 1u);
    EXPECT_EQ(bench.task.last_restart().text(), "it has other calibration values than after the clear");
    EXPECT_EQ(clears(bench), 2);
}

TEST(CalibrationRestarts, between_the_values_and_the_fit_are_detected_too) {
    CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Step::confirm));
    bench.restart(600ms);
    is_calibrated(bench);
    EXPECT_EQ(bench.task.restarts(), 1u);
}

TEST(CalibrationRestarts, a_gap_of_more_than_half_a_second_counts_as_a_restart) {
    for (const auto& [gap, restarts] : {std::pair{460ms, 0u}, {540ms, 1u}, {3000ms, 1u}}) {
        CalibrationBench bench;
        bench.shows_the_clear = false;
        ASSERT_TRUE(bench.run_to(Step::turn, 2));
        if (restarts > 0) bench.restart(gap);
        bench.is_dead = true;
        bench.run(gap);
        bench.is_dead = false;
        is_calibrated(bench);
        EXPECT_EQ(bench.task.restarts(), restarts) << gap.count() << " ms";
    }
}

TEST(CalibrationRestarts, unrequested_device_info_counts_as_a_restart) {
    CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Step::turn, 1));
    bench.run(5s);    // longer than an answer to the last question may take
    bench.restart(0s);
    bench.announce();
    EXPECT_EQ(bench.task.step(), Step::clear);
    EXPECT_EQ(bench.task.last_restart().text(), "it sent its device info unasked");
    is_calibrated(bench);
    EXPECT_EQ(clears(bench), 2);
}

TEST(CalibrationRestarts, requested_device_info_does_not_count_as_a_restart) {
    CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Step::turn, 1));
    bench.run(5s);
    bench.device.expect_info(bench.now);
    bench.announce();
    EXPECT_EQ(bench.task.step(), Step::turn);
    is_calibrated(bench);
    EXPECT_EQ(clears(bench), 1);
}

// It restarts before it has written its flash. On the face on which it is verified, the old values are as good as the new ones.
TEST(CalibrationRestarts, after_the_store_are_detected_by_the_values) {
    for (const Duration later : {100ms, 300ms, 1000ms, 2000ms}) {
        CalibrationBench bench;
        bench.sensor = {{0, 60, 0}, {0.97, 1, 1.03}};
        bench.flash = CalibrationBench::raw;
        bench.flash[1] = 60;
        bench.load_flash();
        const auto old = bench.flash;
        ASSERT_TRUE(bench.run_to(Step::verify));
        bench.run(later);
        if (bench.task.end()) continue;    // it was verified before
        bench.flash = old;
        bench.restart(200ms);
        bench.run();
        ASSERT_TRUE(bench.task.end());
        EXPECT_EQ(bench.task.end()->ending, Ending::failed) << bench.task.end()->fault.text();
        EXPECT_TRUE(bench.task.has_old_values());
        EXPECT_EQ(bench.flash, old);
    }
}

TEST(CalibrationRestarts, changed_device_info_counts_as_a_restart) {
    CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Step::turn, 1));
    bench.device.expect_info(bench.now);
    bench.announce(101);
    EXPECT_EQ(bench.task.step(), Step::clear);
    EXPECT_EQ(bench.task.last_restart().text(), "its device info has changed");
}

// Other sensitivities, for a sensor without offsets: the face on which it lies last does not show the error.
void make_sensitive(CalibrationBench& bench) {
    bench.sensor = {{}, {0.95, 1.05, 1}};
    bench.flash = CalibrationBench::raw;
    bench.flash[3] = static_cast<float>(1 / 0.95);
    bench.flash[4] = static_cast<float>(1 / 1.05);
    bench.load_flash();
}

TEST(CalibrationRestarts, directly_after_the_clear_are_detected) {
    for (const Duration silence : {600ms, 900ms})
        for (const bool shows : {true, false}) {
            CalibrationBench bench;
            make_sensitive(bench);
            bench.shows_the_clear = shows;
            bool is_done = false;
            bench.each_step = [&] {
                if (!bench.actions.empty() && !std::exchange(is_done, true)) bench.restart(silence);
            };
            is_calibrated(bench);
            EXPECT_EQ(bench.task.restarts(), 1u);
            EXPECT_EQ(bench.task.last_restart().text().find("no samples for "), 0u) << bench.task.last_restart().text();
        }
}

TEST(CalibrationRestarts, that_only_the_samples_show_are_detected_in_the_fit) {
    CalibrationBench bench;
    make_sensitive(bench);
    bench.shows_the_clear = false;
    bool is_done = false;
    bench.each_step = [&] {
        if (!bench.actions.empty() && !std::exchange(is_done, true)) bench.restart(300ms);
    };
    is_calibrated(bench);
    EXPECT_EQ(bench.task.restarts(), 1u);
    EXPECT_EQ(bench.task.last_restart().text(), "its samples were already corrected");
    EXPECT_EQ(clears(bench), 2);
}

// Its old values belong to another sensor: this is certain after the second clear.
TEST(CalibrationRestarts, a_device_that_needs_no_correction_is_calibrated_at_the_second_attempt) {
    CalibrationBench bench;
    bench.sensor = {{}, {1, 1, 1}};
    is_calibrated(bench);
    EXPECT_EQ(bench.task.restarts(), 1u);
    EXPECT_EQ(clears(bench), 2);
}

TEST(CalibrationRestarts, a_gap_before_the_first_sample_is_compared_with_the_rate_after_it) {
    Device device{0xDC};
    const TimePoint start{};
    RestartWatch fast{device, start};
    fast.sampled(start + 700ms);
    EXPECT_TRUE(fast.sign(device).empty()) << "its pace is not known yet";
    fast.sampled(start + 710ms);
    fast.sampled(start + 720ms);
    EXPECT_EQ(fast.sign(device).text(), "no samples for 0.7 s");
    RestartWatch slow{device, start};
    slow.sampled(start + 700ms);
    slow.sampled(start + 1700ms);
    slow.sampled(start + 2700ms);
    EXPECT_TRUE(slow.sign(device).empty());
    RestartWatch after_one{device, start};    // that was in flight
    after_one.sampled(start);
    TimePoint now = start + 700ms;
    for (int i = 0; i < 20; ++i) after_one.sampled(now += 10ms);
    EXPECT_EQ(after_one.sign(device).text(), "no samples for 0.7 s");
}

TEST(CalibrationRestarts, unrequested_device_info_directly_after_an_answer_counts_as_a_restart) {
    CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Step::turn, 1));
    bench.device.expect_info(bench.now);
    bench.announce();
    bench.run(1s);
    EXPECT_EQ(bench.task.step(), Step::turn);
    bench.restart(0s);
    bench.announce();
    EXPECT_EQ(bench.task.last_restart().text(), "it sent its device info unasked");
    is_calibrated(bench);
    EXPECT_EQ(clears(bench), 2);
}

// One sample a second is its pace, not a series of restarts.
TEST(CalibrationRestarts, a_gap_of_a_slow_device_is_compared_with_its_rate) {
    Device device{0xDC};
    RestartWatch watch{device, TimePoint{}};
    TimePoint now{};
    for (int i = 0; i < 20; ++i) watch.sampled(now += 1s);
    EXPECT_TRUE(watch.sign(device).empty());
    watch.sampled(now += 3100ms);
    EXPECT_EQ(watch.sign(device).text(), "no samples for 3.1 s");
}

TEST(CalibrationRestarts, six_times_in_a_row_end_the_calibration) {
    CalibrationBench bench;
    for (int i = 0; i < 6; ++i) {
        ASSERT_TRUE(bench.run_to(Step::turn, 1)) << i;
        bench.restart(600ms);
        bench.run(700ms);
    }
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(bench.task.end()->ending, Ending::failed);
    EXPECT_EQ(bench.task.end()->fault.text(), "0xDC restarted 6 times (no samples for 0.6 s); the old values are restored");
}

// The device erases flash, for instance. Whether it restarted can't be seen.
TEST(CalibrationRestarts, silence_after_each_clear_is_reported_and_ends_the_calibration) {
    for (const auto& [silence, words] : {std::pair{800ms, "0.8 s"}, {3000ms, "3.0 s"}}) {
        CalibrationBench bench;
        const auto old = bench.flash;
        std::size_t seen = 0;
        TimePoint until{};
        bench.each_step = [&, time = silence] {
            if (bench.actions.size() > seen && bench.actions.back() == 0x20) until = bench.now + time;
            seen = bench.actions.size();
            bench.is_dead = bench.now < until;
        };
        const TimePoint begin = bench.now;
        bench.run();
        ASSERT_TRUE(bench.task.end());
        EXPECT_EQ(bench.task.end()->fault.text(),
                  std::string{"0xDC was silent for "} + words +
                      " after each of 3 clears, which can't be distinguished from a restart with its old "
                      "calibration; the old values are restored");
        EXPECT_EQ(clears(bench), 3);
        EXPECT_LT(bench.now - begin, 3 * silence + 3s);
        EXPECT_EQ(bench.flash, old);
    }
}

// It restarts so fast that there is no sign, and its parameters never show that they are cleared.
TEST(CalibrationRestarts, without_any_sign_are_detected_by_the_corrected_samples_at_the_end) {
    CalibrationBench bench;
    const auto old = bench.flash;
    bench.shows_the_clear = false;
    ASSERT_TRUE(bench.run_to(Step::turn));
    bench.restart(0s);
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(bench.task.end()->ending, Ending::failed) << bench.worst_face();
    EXPECT_NE(bench.task.end()->fault.text().find("not verified: "), std::string::npos) << bench.task.end()->fault.text();
    EXPECT_NE(bench.task.end()->fault.text().find("; the old values are restored"), std::string::npos)
        << bench.task.end()->fault.text();
    EXPECT_EQ(bench.flash, old);
}

// Such as (raw - O) / S: a face with sensitivity 1 does not show this, so one more face is requested.
TEST(CalibrationRestarts, the_old_values_of_a_device_that_uses_another_formula_are_restored) {
    const auto divides = [](CalibrationBench::Values v) {
        for (std::size_t i = 3; i < 6; ++i) v[i] = 1 / v[i];
        return v;
    };
    const auto adds = [](CalibrationBench::Values v) {
        for (std::size_t i = 0; i < 3; ++i) v[i] = -v[i];
        return v;
    };
    for (CalibrationBench::Values (*const formula)(CalibrationBench::Values) : {+divides, +adds}) {
        CalibrationBench bench;
        const auto old = bench.flash;
        bench.as_it_uses = formula;
        bench.run();
        ASSERT_TRUE(bench.task.end());
        EXPECT_EQ(bench.task.end()->ending, Ending::failed) << bench.worst_face();
        EXPECT_EQ(bench.task.end()->fault.text().find("not verified: "), 0u) << bench.task.end()->fault.text();
        EXPECT_EQ(bench.flash, old);
    }
}

TEST(CalibrationRestarts, values_that_the_device_uses_some_seconds_after_the_store_are_accepted) {
    CalibrationBench bench;
    bench.uses_after = 7s;
    is_calibrated(bench);
}

TEST(CalibrationRestarts, the_old_values_are_restored_when_the_device_stores_but_does_not_use_the_new_ones) {
    CalibrationBench bench;
    const auto old = bench.flash;
    bench.uses_nothing = true;
    ASSERT_TRUE(bench.run_to(Step::verify));
    const TimePoint stored_at = bench.now;
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(bench.task.end()->ending, Ending::failed);
    EXPECT_NE(bench.task.end()->fault.text().find("cm/s² on -z instead of"), std::string::npos) << bench.task.end()->fault.text();
    EXPECT_LT(bench.now - stored_at, Calibration::time_to_verify + 5s);
    EXPECT_EQ(bench.flash, old);
    EXPECT_TRUE(bench.task.has_old_values());
}

TEST(CalibrationRestarts, the_old_values_are_restored_when_the_device_is_moved_before_verification) {
    CalibrationBench bench;
    const auto old = bench.flash;
    ASSERT_TRUE(bench.run_to(Step::verify));
    bench.holds_still = false;
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(
        bench.task.end()->fault.text(),
        "the new values could not be verified: it did not lie still on -z when they were stored; the old values are restored");
    EXPECT_EQ(bench.flash, old);
}

TEST(CalibrationRestarts, a_lost_device_is_reported_within_five_seconds) {
    for (const Step step : {Step::clear, Step::turn, Step::confirm, Step::write, Step::verify, Step::restore}) {
        CalibrationBench bench;
        bench.uses_nothing = step == Step::restore;
        ASSERT_TRUE(bench.run_to(step == Step::clear ? Step::keep : step)) << int(step);
        bench.is_dead = true;
        const TimePoint died = bench.now;
        bench.run();
        ASSERT_TRUE(bench.task.end());
        EXPECT_LE(bench.now - died, 5s) << int(step);
        EXPECT_NE(bench.task.end()->fault.text().find("the old values could not be written back"), std::string::npos)
            << bench.task.end()->fault.text();
        EXPECT_FALSE(bench.task.has_old_values());
    }
}

TEST(CalibrationRestarts, a_device_that_sends_no_samples_is_reported) {
    CalibrationBench bench;
    ASSERT_TRUE(bench.run_to(Step::turn));
    TimePoint last_heard = bench.now;
    while (!bench.task.end() && bench.now < last_heard + 20s) {    // it still sends its mode
        bench.now += 100ms;
        const auto mode = support::frame(0xDC, 0xFF, 0x06, {1, 0, 0, 0, 0});
        bench.device.take(FrameView{mode}, bench.now);
        bench.task.receive(FrameView{mode}, bench.now);
        while (const auto asked = bench.device.next_frame(bench.now))
            for (const auto& answer : bench.fake.take(*asked)) bench.device.take(FrameView{answer}, bench.now);
        bench.task.look(bench.now);
    }
    ASSERT_TRUE(bench.task.end());
    EXPECT_LE(bench.now - last_heard, 6s);
    EXPECT_EQ(bench.task.end()->fault.text(),
              "0xDC is online, but sends no samples: inertial (0x01); the old values are restored");
}

// For any time and duration of the restart, the stored values at the end are right, or are the old ones.
TEST(CalibrationRestarts, at_any_time_never_leave_a_wrong_calibration) {
    int good = 0, undone = 0;
    for (const Duration silence : {0ms, 200ms, 700ms, 2500ms})
        for (const bool shows : {true, false})
            for (Duration at{}; at < 22s; at += support::sanitized ? 3060ms : 340ms) {
                CalibrationBench bench;
                const auto old = bench.flash;
                bench.shows_the_clear = shows;
                const TimePoint when = bench.now + at;
                bool is_done = false;
                bench.each_step = [&] {
                    if (bench.now >= when && !std::exchange(is_done, true)) bench.restart(silence);
                };
                bench.run();
                ASSERT_TRUE(bench.task.end());
                const bool is_good = bench.task.end()->ending == Ending::done;
                const bool is_seen = shows || silence > 500ms;
                if (is_seen) (is_good ? good : undone) += 1;
                if (is_good) {
                    ASSERT_LT(bench.worst_face(), is_seen ? 2 : 4) << at.count() << ' ' << silence.count() << ' ' << shows;
                } else {
                    ASSERT_EQ(bench.flash, old) << bench.task.end()->fault.text();
                }
            }
    EXPECT_GT(good, 20 * undone) << good << ' ' << undone;
}

// Its old calibration is right: any new calibration made of corrected samples is worse.
const std::array<CalibrationBench::Sensor, 5> sensors{{{{}, {1 / 1.05, 1, 1}},
                                                       {{}, {1 / 1.02, 1, 1}},
                                                       {{1, -1, 2}, {1 / 1.01, 1 / 0.99, 1}},
                                                       {{12, -9, 15}, {1 / 1.01, 1 / 0.99, 1}},
                                                       {{25, -18, 40}, {1.02, 0.985, 1.01}}}};

void has_right_values(CalibrationBench& bench, const std::string& what) {
    const auto old = bench.flash;
    bench.run();
    ASSERT_TRUE(bench.task.end()) << what;
    if (bench.task.end()->ending == Ending::done) {
        ASSERT_LT(bench.worst_face(), 4) << what;
    } else {
        ASSERT_EQ(bench.flash, old) << what << ": " << bench.task.end()->fault.text();
    }
}

TEST(CalibrationRestarts, a_clear_that_is_acknowledged_and_ignored_never_leaves_wrong_values) {
    for (const auto& sensor : sensors) {
        CalibrationBench bench;
        bench.make_right(sensor);
        bench.ignores_the_clear = true;
        has_right_values(bench, "ignored");
        ASSERT_TRUE(bench.task.end());
        EXPECT_EQ(bench.task.end()->ending, Ending::failed);
    }
}

TEST(CalibrationRestarts, a_clear_that_only_the_parameters_show_never_leaves_wrong_values) {
    for (const auto& sensor : sensors) {
        CalibrationBench bench;
        bench.make_right(sensor);
        bench.uses_the_clear = false;
        has_right_values(bench, "only in the parameters");
    }
}

TEST(CalibrationRestarts, a_calibration_that_is_partly_right_is_not_made_worse_by_an_ignored_clear) {
    CalibrationBench bench;
    bench.sensor = {{}, {1 / 1.05, 1, 1}};
    bench.flash = {0, 15, 0, 1.05f, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    bench.load_flash();
    const double before = bench.worst_face();
    bench.ignores_the_clear = true;
    bench.run();
    ASSERT_TRUE(bench.task.end());
    EXPECT_EQ(bench.task.end()->ending, Ending::failed);
    EXPECT_EQ(bench.worst_face(), before);
}

TEST(CalibrationRestarts, after_each_clear_never_leave_wrong_values) {
    for (const auto& sensor : sensors)
        for (const bool shows : {true, false}) {
            CalibrationBench bench;
            bench.make_right(sensor);
            bench.shows_the_clear = shows;
            std::ptrdiff_t seen = 0;
            bench.each_step = [&] {
                if (std::exchange(seen, clears(bench)) != clears(bench)) bench.restart(0s);
            };
            has_right_values(bench, shows ? "shown" : "not shown");
        }
}

TEST(CalibrationRestarts, a_short_restart_of_a_device_that_does_not_show_the_clear_leaves_no_wrong_values) {
    int good = 0, undone = 0;
    for (const auto& sensor : sensors)
        for (Duration at = 300ms; at < 15s; at += support::sanitized ? 4500ms : 500ms) {
            CalibrationBench bench;
            bench.make_right(sensor);
            bench.flash[0] += 5;    // it needs a calibration
            bench.load_flash();
            bench.shows_the_clear = false;
            const TimePoint when = bench.now + at;
            bool is_done = false;
            bench.each_step = [&] {
                if (bench.now >= when && !std::exchange(is_done, true)) bench.restart(200ms);
            };
            has_right_values(bench, std::to_string(at / 1ms) + " ms");
            (bench.task.end()->ending == Ending::done ? good : undone) += 1;
        }
    EXPECT_GT(good, 0);
    EXPECT_GT(undone, 0);
}

TEST(CalibrationRestarts, rounded_values_are_no_worse_than_the_old_ones) {
    for (const double mul : {200.0, 1000.0})
        for (int i = -20; i <= 20; i += support::sanitized ? 5 : 1) {
            CalibrationBench bench;
            const double x = 1 + i / 997.0, y = 1 - i / 1700.0, z = 1 + i / 3100.0;
            bench.sensor = {{3 + i / 40.0, -2, 1}, {1 / x, 1 / y, 1 / z}};
            bench.flash = {3, -2, 1.4f, static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 1, 0, 0, 0, 1, 0,
                           0, 0,  1};
            for (std::size_t k = 0; k < 6; ++k)
                bench.flash[k] = static_cast<float>(std::round(double{bench.flash[k]} * double{mul}) / double{mul});
            bench.make_scaled(static_cast<std::int32_t>(mul));
            bench.load_flash();
            const double before = bench.worst_face();
            bench.run();
            ASSERT_TRUE(bench.task.end());
            EXPECT_LE(bench.worst_face(), before + 0.9) << mul << ' ' << i;    // samples are integers
        }
}

}    // namespace
}    // namespace ano::host::calibration_restarts_tests
