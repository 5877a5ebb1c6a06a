#include <gtest/gtest.h>
#include <device/device.hpp>

#include <string>

#include "talk.hpp"

namespace log_tests {
namespace {

using ano::device::Device;
using ano::device::LogColor;
using namespace talk;
using support::operator+;

TEST(Log, sends_a_line_in_a_colour) {
    Device device{{.id = self}};
    EXPECT_TRUE(device.log("ready"));
    EXPECT_TRUE(device.log("hot", LogColor::red));
    EXPECT_TRUE(device.log("cold", LogColor::blue, 0x05));
    const auto lines = heard(device);
    ASSERT_EQ(lines.size(), 3u);
    EXPECT_EQ(lines[0], expected_reply(0xA0, Bytes{0} + bytes("ready")));
    EXPECT_EQ(lines[1], expected_reply(0xA0, Bytes{1} + bytes("hot")));
    EXPECT_EQ(lines[2], support::frame(self, 5, 0xA0, Bytes{3} + bytes("cold")));
}

TEST(Log, may_have_a_number) {
    Device device{{.id = self}};
    EXPECT_TRUE(device.log(1.5f, "bar"));
    EXPECT_EQ(heard(device).front(), expected_reply(0xA1, Bytes{0, 0, 0xC0, 0x3F} + bytes("bar")));
}

TEST(Log, is_cut_to_fit_a_frame_and_lost_when_the_queue_is_full) {
    Device device{{.id = self}};
    EXPECT_TRUE(device.log(std::string(1000, 'x')));
    EXPECT_TRUE(device.log(1.0f, std::string(1000, 'x')));
    for (const auto& line : heard(device)) EXPECT_EQ(line.size(), ano::overhead + 198);
    for (std::size_t i = 0; i < ano::device::Outgoing::max_frames; ++i) EXPECT_TRUE(device.log("x"));
    EXPECT_FALSE(device.log("one too many"));
}

}    // namespace
}    // namespace log_tests
