// Samples that come late, behind a low pass, or of a device that is tilted: what is stored is right, or the old values are back.
#include <support/calibrated_device.hpp>
#include <support/sanitized.hpp>

#include <gtest/gtest.h>

namespace ano::host::calibration_samples_tests {
namespace {

using namespace std::chrono_literals;
using support::CalibrationBench;

// Whether it was calibrated.
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
TEST(CalibrationSamples, that_come_late_are_none_of_before_the_clear_or_the_store) {
    for (Duration late{}; late <= Calibration::most_late; late += support::sanitized ? 1s : 200ms)
        for (const bool shows_the_clear : {true, false}) {
            CalibrationBench bench;
            bench.late = late;
            bench.shows_the_clear = shows_the_clear;
            EXPECT_TRUE(is_calibrated(bench)) << late / 1ms << " ms: " << bench.task.end()->what;
            EXPECT_LT(bench.worst_face(), 2) << late / 1ms << " ms";
        }
}

TEST(CalibrationSamples, behind_a_low_pass_count_when_they_have_settled) {
    for (const Duration step : {2ms, 5ms, 20ms, 50ms})
        for (const double smooths : {0.05, 0.25, 0.5, 1.0, 2.0}) {
            if (support::sanitized && (step < 20ms || smooths < 1)) continue;
            CalibrationBench bench;
            bench.step = step;
            bench.smooths = smooths;
            EXPECT_TRUE(is_calibrated(bench)) << step / 1ms << " ms " << smooths << " s: " << bench.task.end()->what;
            EXPECT_LT(bench.worst_face(), smooths > 1 ? 8 : 5) << step / 1ms << " ms, " << smooths << " s";
        }
}

TEST(CalibrationSamples, of_a_device_that_is_tilted_do_not_count) {
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

}    // namespace
}    // namespace ano::host::calibration_samples_tests
