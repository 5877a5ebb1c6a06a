// Samples that arrive late, pass a low pass, or are from a tilted device: the stored values are right, or the old ones are
// restored.
#include <support/calibrated_device.hpp>
#include <support/sanitized.hpp>

#include <gtest/gtest.h>

namespace ano::host::calibration_samples_tests {
namespace {

using namespace std::chrono_literals;
using support::CalibrationBench;

// Returns whether it was calibrated.
bool is_calibrated(CalibrationBench& bench) {
    bench.run(12min);
    const auto old = CalibrationBench{}.flash;
    EXPECT_TRUE(bench.task.end());
    if (!bench.task.end() || bench.task.end()->ending != Ending::done) {
        EXPECT_EQ(bench.flash, old) << "the old values are back";
        return false;
    }
    return true;
}

// As over a radio that sends answers first.
TEST(CalibrationSamples, that_arrive_late_from_before_the_clear_or_the_store_do_not_count) {
    for (Duration late{}; late <= Calibration::most_late; late += support::sanitized ? 1s : 200ms)
        for (const bool shows_the_clear : {true, false}) {
            CalibrationBench bench;
            bench.late = late;
            bench.shows_the_clear = shows_the_clear;
            EXPECT_TRUE(is_calibrated(bench)) << late / 1ms << " ms: " << bench.task.end()->fault.text();
            EXPECT_LT(bench.worst_face(), 2) << late / 1ms << " ms";
        }
}

TEST(CalibrationSamples, of_a_device_with_a_low_pass_count_once_they_have_settled) {
    for (const Duration step : {2ms, 5ms, 20ms, 50ms})
        for (const double smooths : {0.05, 0.25, 0.5, 1.0, 2.0}) {
            if (support::sanitized && (step < 20ms || smooths < 1)) continue;
            CalibrationBench bench;
            bench.step = step;
            bench.smooths = smooths;
            EXPECT_TRUE(is_calibrated(bench)) << step / 1ms << " ms " << smooths << " s: " << bench.task.end()->fault.text();
            EXPECT_LT(bench.worst_face(), smooths > 1 ? 8 : 5) << step / 1ms << " ms, " << smooths << " s";
        }
}

TEST(CalibrationSamples, of_a_device_that_is_being_tilted_do_not_count) {
    for (const Duration step : {2ms, 20ms, 50ms})
        for (const double tilts : {0.5, 1.0, 2.0, 4.0, 10.0, 30.0}) {
            if (support::sanitized && (step != 20ms || tilts != 2.0)) continue;
            CalibrationBench bench;
            bench.step = step;
            bench.tilts = tilts;
            EXPECT_TRUE(!is_calibrated(bench) || bench.worst_face() < 5)
                << step / 1ms << " ms, " << tilts << " °/s: " << bench.worst_face();
        }
}

const CalibrationBench::Sensor shifted{{25, -18, 40}, {1.02, 0.985, 1.01}};

// Tilts of 1 to 5 degrees, as when placed by hand; the old calibration of the device is good.
TEST(CalibrationSamples, of_faces_that_are_not_level_never_make_a_good_calibration_worse) {
    for (const double off : {0.003, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.1})
        for (std::uint32_t lays = 1; lays <= (support::sanitized ? 1 : 8); ++lays) {
            CalibrationBench bench;
            bench.make_right(shifted);
            bench.flash[0] += 0.3f;
            bench.load_flash();
            bench.lies_off = off;
            bench.lays = lays;
            bench.run(12min);
            ASSERT_TRUE(bench.task.end());
            EXPECT_LT(bench.worst_face(), 1) << off << " rad, seed " << lays << ": " << bench.task.end()->fault.text();
        }
}

// Its offset and sensitivity are found in spite of the tilts.
TEST(CalibrationSamples, of_faces_that_are_not_level_calibrate_a_device_that_was_never_calibrated) {
    for (const double off : {0.003, 0.01, 0.02, 0.04, 0.06})
        for (const bool shows : {true, false}) {
            CalibrationBench bench;
            bench.sensor = shifted;
            bench.flash = CalibrationBench::raw;
            bench.flash[2] = 5;
            bench.load_flash();
            bench.shows_the_clear = shows;
            bench.lies_off = off;
            bench.run(12min);
            ASSERT_TRUE(bench.task.end());
            EXPECT_EQ(bench.task.end()->ending, Ending::done) << bench.task.end()->fault.text();
            EXPECT_LT(bench.worst_face(), 3) << off << " rad";
            EXPECT_LT(bench.task.verified().value_or(1000), 3);
        }
}

TEST(CalibrationSamples, of_a_device_that_sways_slowly_never_make_a_good_calibration_worse) {
    for (const auto& [sways, period] : {std::pair{0.02, 8s}, {0.02, 20s}, {0.02, 40s}, {0.05, 20s}, {0.05, 60s}, {0.1, 60s}})
        for (const Duration step : {20ms, 50ms}) {
            CalibrationBench bench;
            bench.make_right(shifted);
            bench.flash[0] += 0.3f;
            bench.load_flash();
            bench.step = step;
            bench.sways = sways;
            bench.sways_in = period;
            bench.run(12min);
            ASSERT_TRUE(bench.task.end());
            EXPECT_LT(bench.worst_face(), 2) << sways << " rad, " << period / 1s << " s: " << bench.task.end()->fault.text();
        }
}

}    // namespace
}    // namespace ano::host::calibration_samples_tests
