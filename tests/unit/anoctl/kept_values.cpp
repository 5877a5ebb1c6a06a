#include <anoctl/device/kept_values.hpp>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include <support/files.hpp>
#include <support/temp_dir.hpp>

namespace kept_values_tests {
namespace {

using anoctl::keep_in_state_folder;

TEST(KeptValues, are_not_overwritten_and_are_removed_when_no_longer_needed) {
    const support::TempDir dir;
    ::setenv("XDG_STATE_HOME", dir.path().c_str(), 1);
    const std::string file = dir / "anogate/calibration-0xDC-compass.json";
    EXPECT_EQ(keep_in_state_folder("calibration-0xDC-compass.json", "{}"), "");
    EXPECT_EQ(support::file_text(file), "{}");
    EXPECT_NE(keep_in_state_folder("calibration-0xDC-compass.json", "[]").find("anoctl param import " + file), std::string::npos);
    EXPECT_EQ(support::file_text(file), "{}") << "the values from before the crash";
    EXPECT_EQ(keep_in_state_folder("calibration-0xDC-compass.json", "[1]", anoctl::Earlier::replaced), "");
    EXPECT_EQ(support::file_text(file), "[1]") << "of this run";
    EXPECT_EQ(keep_in_state_folder("calibration-0xDC-compass.json", ""), "");
    EXPECT_FALSE(std::filesystem::exists(file));
    ::setenv("XDG_STATE_HOME", (dir / "nothing").c_str(), 1);
    EXPECT_EQ(keep_in_state_folder("never-kept", ""), "") << "what is not there need not go";
    ::setenv("XDG_STATE_HOME", (dir.write("file", "")).c_str(), 1);
    EXPECT_NE(keep_in_state_folder("a", "{}").find("cannot create"), std::string::npos);
    ::unsetenv("XDG_STATE_HOME");
}

TEST(KeptValues, of_an_earlier_run_are_found) {
    const support::TempDir dir;
    ::setenv("XDG_STATE_HOME", dir.path().c_str(), 1);
    const auto is_b = [](std::string_view name) { return name == "b.json"; };
    EXPECT_TRUE(anoctl::texts_in_state_folder(is_b).empty());
    EXPECT_EQ(keep_in_state_folder("a.json", "1"), "");
    EXPECT_EQ(keep_in_state_folder("b.json", "2"), "");
    EXPECT_EQ(anoctl::texts_in_state_folder(is_b), (std::map<std::string, std::string>{{"b.json", "2"}}));
    ::unsetenv("XDG_STATE_HOME");
}

}    // namespace
}    // namespace kept_values_tests
