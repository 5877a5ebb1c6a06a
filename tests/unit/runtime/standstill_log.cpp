#include <runtime/standstill_log.hpp>

#include <support/log_lines.hpp>

#include <gtest/gtest.h>

namespace standstill_log_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

class StandstillLines : public testing::Test {
protected:
    Lines stood(ano::TimePoint now, bool is_reported = true) {
        log.stood({.stood = 1500ms, .is_reported = is_reported}, now);
        return lines.pop_all();
    }

    support::LogLines lines;
    StandstillLog log;
    const Lines line{
        "stalled for at least 1.5 s (stopped, or the computer was too busy): frames received meanwhile count as that old"};
    const ano::TimePoint start{1h};
};

TEST_F(StandstillLines, are_five_at_once_and_then_one_in_ten_seconds) {
    for (int i = 0; i < 5; ++i) EXPECT_EQ(stood(start), line) << i;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(stood(start + 9s), Lines{}) << i;
    EXPECT_EQ(stood(start + 10s), Lines{line[0] + "; 3 more times before"});
    EXPECT_EQ(stood(start + 19s), Lines{});
    EXPECT_EQ(stood(start + 20s), Lines{line[0] + "; 1 more times before"});
    EXPECT_EQ(stood(start + 21s), Lines{});
    log.finish();
    EXPECT_EQ(lines.pop_all(), Lines{"stalled 1 more times"});
}

TEST_F(StandstillLines, are_not_logged_for_stalls_that_are_too_short) {
    EXPECT_EQ(stood(start, false), Lines{});
    log.finish();
    EXPECT_EQ(lines.pop_all(), Lines{});
}

}    // namespace
}    // namespace standstill_log_tests
