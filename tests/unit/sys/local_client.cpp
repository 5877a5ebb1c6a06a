#include <sys/local_client.hpp>

#include <gtest/gtest.h>

#include <pwd.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <string>

namespace anogate::local_client_tests {
namespace {

TEST(LocalClient, is_described_by_its_user_and_a_name_that_cannot_look_like_other_text) {
    std::array<char, 16> before{};
    ASSERT_EQ(::prctl(PR_GET_NAME, before.data()), 0);
    ASSERT_EQ(::prctl(PR_SET_NAME, "x of \x1B\xE2\x80\xAE,0"), 0);
    const passwd* const user = ::getpwuid(::geteuid());
    ASSERT_NE(user, nullptr);
    const std::string number = std::to_string(::getpid());
    EXPECT_EQ(local_client(::geteuid(), ::getpid()), "x_of______0 of " + std::string{user->pw_name} + ", process " + number);
    EXPECT_EQ(::prctl(PR_SET_NAME, before.data()), 0);
}

TEST(LocalClient, is_described_by_numbers_if_the_names_are_not_readable) {
    constexpr uid_t nobody_has = 4'000'000'000;
    constexpr pid_t none = 2'000'000'000;    // more than the kernel assigns
    EXPECT_EQ(local_client(nobody_has, none), "a program of user 4000000000, process 2000000000");
    EXPECT_EQ(local_client(nobody_has, 0), "a program of user 4000000000");
}

}    // namespace
}    // namespace anogate::local_client_tests
