#include <sys/descriptors_left.hpp>
#include <sys/unique_fd.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <vector>

namespace anogate::descriptors_left_tests {
namespace {

constexpr std::size_t most = 64, reserved = 8;

/// With a limit of 64 descriptors, all of them in use.
class DescriptorsLeft : public ::testing::Test {
protected:
    DescriptorsLeft() {
        ::getrlimit(RLIMIT_NOFILE, &before_);
        const rlimit few{most, before_.rlim_max};
        ::setrlimit(RLIMIT_NOFILE, &few);
        for (int fd; (fd = ::dup(STDERR_FILENO)) >= 0;) all_.emplace_back(fd);
    }
    ~DescriptorsLeft() override {
        all_.clear();
        ::setrlimit(RLIMIT_NOFILE, &before_);
    }
    void close_lowest(std::size_t count) { all_.erase(all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(count)); }

private:
    rlimit before_{};
    std::vector<UniqueFd> all_;
};

TEST_F(DescriptorsLeft, are_none_while_only_the_reserved_ones_are_free) {
    EXPECT_EQ(descriptors_left(), 0u);
    EXPECT_FALSE(can_open_descriptors());
    close_lowest(reserved);
    EXPECT_EQ(descriptors_left(), 0u);
    EXPECT_TRUE(can_open_descriptors());
}

TEST_F(DescriptorsLeft, do_not_include_numbers_in_use_above_a_free_one) {
    close_lowest(reserved + 2);
    EXPECT_EQ(descriptors_left(), 2u);
}

TEST(DescriptorsAboveAHole, are_counted_beyond_hundreds_in_use) {
    rlimit limit{};
    ::getrlimit(RLIMIT_NOFILE, &limit);
    if (limit.rlim_cur < 1000) GTEST_SKIP() << "needs a limit of 1000 descriptors (ulimit -n)";
    std::vector<UniqueFd> all;
    for (int i = 0; i < 400; ++i) all.emplace_back(::dup(STDERR_FILENO));
    all.front() = UniqueFd{};
    EXPECT_GT(descriptors_left(), 200u);
}

}    // namespace
}    // namespace anogate::descriptors_left_tests
