// Large bodies in files: they are complete, disappear with their owner, and report a full disk in words.
#include <http/body_file.hpp>
#include <support/temp_dir.hpp>
#include <support/wait.hpp>
#include <sys/asio.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <optional>

namespace anogate::body_file_tests {
namespace {

using namespace std::chrono_literals;

TEST(BodyFile, stores_the_appended_bytes_and_has_no_name) {
    const support::TempDir dir;
    auto made = BodyFile::make(dir / "new/folder");
    ASSERT_TRUE(made) << made.error();
    BodyFile& file = **made;
    EXPECT_EQ(file.append("one "), "");
    EXPECT_EQ(file.append("two"), "");
    EXPECT_EQ(file.size(), 7u);
    std::array<std::uint8_t, 4> read{};
    ASSERT_TRUE(file.read(2, read));
    EXPECT_EQ(std::string(read.begin(), read.end()), "e tw");
    EXPECT_FALSE(file.read(4, read)) << "it ends before";
    EXPECT_TRUE(std::filesystem::is_empty(dir.path() / "new/folder"));
}

TEST(BodyFile, reports_a_full_disk) {
    BodyFile full{UniqueFd{::open("/dev/full", O_RDWR | O_CLOEXEC)}};
    EXPECT_EQ(full.append("x"), "No space left on device");
}

TEST(BodyFile, reports_a_folder_that_is_not_writable) {
    const auto made = BodyFile::make("/proc/nothing");
    ASSERT_FALSE(made);
    EXPECT_TRUE(made.error().starts_with("/proc/nothing: ")) << made.error();
}

struct Keeps : testing::Test {
    ~Keeps() override {
        ::unsetenv("STATE_DIRECTORY");
        ::unsetenv("TMPDIR");
    }
    std::string put(FileKeeper& keeper, const std::string& part) {
        std::optional<std::string> fault;
        keeper.put(part, [&](std::string why) { fault = std::move(why); });
        EXPECT_FALSE(fault) << "never at once";
        EXPECT_TRUE(support::wait_until([&] { return fault.has_value(); }, 10s,
                                        [&] {
                                            io.restart();
                                            io.run_for(1ms);
                                        }));
        return fault.value_or("nothing was said");
    }
    support::TempDir dir;
    asio::io_context io{1};
};

TEST_F(Keeps, a_body_part_by_part_outside_the_main_loop) {
    ::setenv("STATE_DIRECTORY", (dir / "state").c_str(), 1);
    FileKeeper keeper{io};
    EXPECT_EQ(put(keeper, "one "), "");
    EXPECT_EQ(put(keeper, "two"), "");
    ASSERT_TRUE(keeper.whole());
    EXPECT_EQ(keeper.whole()->size(), 7u);
}

TEST_F(Keeps, a_body_elsewhere_if_there_is_no_state_folder) {
    ::setenv("STATE_DIRECTORY", "/proc/nothing", 1);
    ::setenv("TMPDIR", dir.path().c_str(), 1);
    FileKeeper keeper{io};
    EXPECT_EQ(put(keeper, "x"), "");
    ::setenv("TMPDIR", "/proc/nothing", 1);
    FileKeeper none{io};
    const std::string fault = put(none, "x");
    EXPECT_TRUE(fault.starts_with("no space for such a large body: /proc/nothing: ")) << fault;
    EXPECT_NE(fault.find("STATE_DIRECTORY"), std::string::npos);
}

}    // namespace
}    // namespace anogate::body_file_tests
