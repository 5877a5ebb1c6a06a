#include <recording/just_saved.hpp>

#include <gtest/gtest.h>

#include <chrono>

namespace just_saved_tests {
namespace {

using namespace std::chrono_literals;

TEST(JustSaved, contains_a_name_until_the_latest_of_its_times) {
    const ano::TimePoint now = ano::Clock::now();
    anogate::JustSaved saved;
    saved.add("a", now + 10s);
    saved.add("b", now + 10s);
    saved.add("b", now + 20s);
    saved.add("b", now + 15s);
    EXPECT_TRUE(saved.contains("a", now + 9s));
    EXPECT_FALSE(saved.contains("c", now));
    EXPECT_FALSE(saved.contains("a", now + 10s));
    EXPECT_TRUE(saved.contains("b", now + 19s));
}

}    // namespace
}    // namespace just_saved_tests
