#include <sys/files/held_folder.hpp>

#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

namespace held_folder_tests {
namespace {

using anogate::HeldFolder;
namespace fs = std::filesystem;

struct HeldFolders : testing::Test {
    /// Our own folder within a folder with that mode.
    std::string below(const std::string& name, mode_t mode) const {
        fs::create_directories(dir / name + "/inner");
        const std::string inner = dir / name + "/inner";
        EXPECT_EQ(::chmod(inner.c_str(), 0755), 0);
        EXPECT_EQ(::chmod((dir / name).c_str(), mode), 0);
        return inner;
    }
    static bool is_fixed(const std::string& path) {
        const auto held = HeldFolder::of(path);
        EXPECT_TRUE(held) << held.error();
        return held && held->is_fixed();
    }

    support::TempDir dir;
};

TEST_F(HeldFolders, are_fixed_if_no_other_user_may_change_any_part_of_the_path) {
    EXPECT_TRUE(is_fixed(below("ours", 0755)));
    EXPECT_TRUE(is_fixed(below("sticky", 01777))) << "only its owner moves what is there";
    EXPECT_FALSE(is_fixed(below("everybodys", 0777)));
    EXPECT_FALSE(is_fixed(below("of_a_group", 0775)));
    EXPECT_FALSE(is_fixed(below("of_others", 0757)));
}

TEST_F(HeldFolders, follow_links_of_this_user_and_hold_their_targets) {
    const std::string there = below("ours", 0755);
    fs::create_symlink(there, dir / "absolute");
    fs::create_symlink("absolute/../inner", dir / "relative");
    const auto held = HeldFolder::of(dir / "relative");
    ASSERT_TRUE(held) << held.error();
    EXPECT_TRUE(fs::equivalent(held->at("."), there));
}

TEST_F(HeldFolders, refuse_links_that_lead_to_each_other) {
    fs::create_symlink("b", dir / "a");
    fs::create_symlink("a", dir / "b");
    const auto held = HeldFolder::of(dir / "a");
    ASSERT_FALSE(held);
    EXPECT_NE(held.error().find(std::strerror(ELOOP)), std::string::npos) << held.error();
}

}    // namespace
}    // namespace held_folder_tests
