#include <sys/files/read_file.hpp>

#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <unistd.h>
#include <string>
#include <system_error>

namespace anogate::read_file_tests {
namespace {

std::error_code fault_of(const std::string& path) {
    std::error_code error;
    EXPECT_EQ(read_file(path, 10, error), "");
    return error;
}

TEST(ReadFile, returns_the_whole_text_up_to_a_size) {
    const support::TempDir dir;
    std::error_code error;
    EXPECT_EQ(read_file(dir.write("ten", "0123456789"), 10, error), "0123456789");
    EXPECT_FALSE(error);
    EXPECT_EQ(read_file(dir.write("none", ""), 10, error), "");
    EXPECT_FALSE(error);
    EXPECT_EQ(fault_of(dir.write("eleven", "0123456789a")), std::errc::file_too_large);
    EXPECT_EQ(fault_of(dir / "missing"), std::errc::no_such_file_or_directory);
    EXPECT_EQ(fault_of(dir / ""), std::errc::is_a_directory);
}

// It is a regular file of 0 bytes, whose reader waits for the kernel's next message.
TEST(ReadFile, rejects_a_file_without_an_end_at_once) {
    if (::access("/proc/kmsg", R_OK) != 0) GTEST_SKIP() << "only root may read it";
    ::alarm(10);
    std::error_code error;
    EXPECT_EQ(read_file("/proc/kmsg", std::size_t{64} << 20, error), "");
    EXPECT_TRUE(error);
    ::alarm(0);
}

}    // namespace
}    // namespace anogate::read_file_tests
