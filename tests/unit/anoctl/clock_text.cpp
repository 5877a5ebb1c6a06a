#include <anoctl/text/frame_printer.hpp>

#include <gtest/gtest.h>

namespace clock_text_tests {
namespace {

TEST(ClockText, has_milliseconds) {
    EXPECT_EQ(anoctl::clock_text(1.25).substr(5), ":01.250");
    EXPECT_EQ(anoctl::clock_text(59.5).substr(5), ":59.500");
}

}    // namespace
}    // namespace clock_text_tests
