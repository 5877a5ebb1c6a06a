#include <sys/process_figures.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <chrono>

namespace anogate::process_figures_tests {
namespace {

TEST(ProcessFigures, are_read_from_a_line_of_the_system) {
    const auto times = parse_stat("1234 (a name) with) R 1 -1 3 0 -1 5 6 7 8 9 14 15 16 17 20 0 1 0 22 23 24 25 26\n");
    ASSERT_TRUE(times);
    EXPECT_EQ(times->ticks, 14u + 15u);
    EXPECT_EQ(times->started_ticks, 22u);
    EXPECT_EQ(times->virtual_bytes, 23u);
    EXPECT_EQ(times->resident_pages, 24u);
}

TEST(ProcessFigures, are_not_read_from_an_invalid_line) {
    for (const char* text : {"", "1234 (name", "1234 (name)", "1234 (name) R 1 2 3"}) EXPECT_FALSE(parse_stat(text)) << text;
}

TEST(ProcessFigures, are_those_of_this_process) {
    const ProcessFigures before = this_process();
    EXPECT_GT(before.resident_bytes, 1'000'000u);
    EXPECT_GT(before.virtual_bytes, before.resident_bytes);
    EXPECT_GT(before.max_fds, 0u);
    const double now = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    EXPECT_LT(before.started_at_s, now + 1);
    EXPECT_GT(before.started_at_s, now - 3600);
    ASSERT_TRUE(before.open_fds);
    const int one = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    EXPECT_EQ(this_process().open_fds, *before.open_fds + 1);
    ::close(one);
}

}    // namespace
}    // namespace anogate::process_figures_tests
