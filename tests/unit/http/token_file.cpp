#include <http/listeners/token_file.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace anogate::http::token_file_tests {
namespace {

const std::string long_enough = "0123456789abcdef";

std::string fault_of(std::string_view text) {
    const auto tokens = parse_tokens(text);
    return tokens ? "" : tokens.error();
}

TEST(TokenFile, contains_a_right_and_a_token_per_line) {
    const auto tokens = parse_tokens("# mine\n\nview " + long_enough + "\r\n  control\t" + long_enough + "-._~+/=  ");
    ASSERT_TRUE(tokens) << tokens.error();
    EXPECT_EQ(*tokens, (std::vector<Token>{{Access::view, long_enough}, {Access::control, long_enough + "-._~+/="}}));
}

TEST(TokenFile, with_an_error_is_reported_by_line_number_without_its_content) {
    EXPECT_EQ(fault_of("view " + long_enough + "\nadmin " + long_enough),
              "line 2: a line must be 'view TOKEN' or 'control TOKEN'");
    for (const std::string bad :
         {"view short", "view", "control 0123456789abcde\"", "control 0123456789 abcdef", "view \xC3\xA9"})
        EXPECT_EQ(fault_of(bad), "line 1: a token has 16 to 256 letters, digits or characters of -._~+/=") << bad;
    EXPECT_EQ(fault_of("view " + std::string(256, 'x')), "");
    EXPECT_NE(fault_of("view " + std::string(257, 'x')), "");
    for (const std::string none : {"", "\n# nothing\n"})
        EXPECT_NE(fault_of(none).find("it contains no token"), std::string::npos);
}

TEST(TokenFile, that_is_missing_is_created_for_its_owner_only) {
    support::TempDir dir;
    const std::string path = dir / "state/anogate/token";
    const auto made = read_or_make_tokens(path);
    ASSERT_TRUE(made) << made.error();
    ASSERT_EQ(made->size(), 2u);
    EXPECT_EQ((*made)[0].access, Access::view);
    EXPECT_EQ((*made)[1].access, Access::control);
    EXPECT_EQ((*made)[0].text.size(), 64u);
    EXPECT_NE((*made)[0].text, (*made)[1].text);
    struct stat facts {};
    ASSERT_EQ(::stat(path.c_str(), &facts), 0);
    EXPECT_EQ(facts.st_mode & 0777, 0600u);
    EXPECT_EQ(read_or_make_tokens(path), made) << "read again, they are the same";
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator{dir / "state/anogate"}, {}), 1) << "nothing is left beside it";
}

TEST(TokenFile, is_checked_without_being_created) {
    support::TempDir dir;
    const auto fault = [](const std::string& path) {
        const auto checked = check_tokens(path);
        return checked ? "" : checked.error();
    };
    EXPECT_EQ(fault(dir / "state/anogate/token"), "");
    EXPECT_FALSE(std::filesystem::exists(dir / "state"));
    const std::string path = dir.write("token", "view " + long_enough + "\n");
    std::filesystem::permissions(path, std::filesystem::perms{0600});
    EXPECT_EQ(fault(path), "");
    EXPECT_EQ(fault(path + "/token"), path + "/token: Not a directory");
    std::filesystem::permissions(path, std::filesystem::perms{0644});
    EXPECT_EQ(fault(path), path + ": every user of this computer can read it; run chmod o= " + path);
    EXPECT_EQ(fault(dir.path()), dir.path().string() + ": is not a file");
    if (::geteuid() != 0) {
        EXPECT_EQ(fault("/proc/token"), "/proc/token: Permission denied");
    }
}

TEST(TokenFile, that_every_user_can_read_is_rejected) {
    support::TempDir dir;
    const std::string path = dir / "token";
    std::ofstream{path} << "view " << long_enough << "\n";
    ::chmod(path.c_str(), 0644);
    const auto open = read_or_make_tokens(path);
    ASSERT_FALSE(open);
    EXPECT_EQ(open.error(), path + ": every user of this computer can read it; run chmod o= " + path);
    ::chmod(path.c_str(), 0640);
    EXPECT_TRUE(read_or_make_tokens(path));
}

TEST(TokenFile, that_is_not_a_file_or_cannot_be_created_is_reported) {
    support::TempDir dir;
    EXPECT_EQ(read_or_make_tokens(dir.path().string()).error(), dir.path().string() + ": is not a file");
    ASSERT_EQ(::mkfifo((dir / "pipe").c_str(), 0600), 0);
    EXPECT_EQ(read_or_make_tokens(dir / "pipe").error(), (dir / "pipe") + ": is not a file");
    std::ofstream{dir / "file"};
    const auto below = read_or_make_tokens(dir / "file/token");
    ASSERT_FALSE(below);
    EXPECT_NE(below.error().find("Not a directory"), std::string::npos) << below.error();
}

}    // namespace
}    // namespace anogate::http::token_file_tests
