#include <ros/cdr_reader.hpp>

#include <gtest/gtest.h>

#include <support/bytes.hpp>

namespace cdr_reader_tests {
namespace {

using namespace anogate;
using support::hex;

const support::Bytes twist = hex(
    "00 01 00 00  00 00 00 00 00 00 F0 3F  00 00 00 00 00 00 00 40  00 00 00 00 00 00 08 40"
    " 00 00 00 00 00 00 00 00  00 00 00 00 00 00 00 00  00 00 00 00 00 00 E0 BF");

TEST(CdrReading, reads_a_twist) {
    const auto value = read_twist(twist);
    ASSERT_TRUE(value);
    EXPECT_EQ(value->linear, (std::array<double, 3>{1, 2, 3}));
    EXPECT_EQ(value->angular, (std::array<double, 3>{0, 0, -0.5}));
}

TEST(CdrReading, reads_both_byte_orders) {
    const auto text = read_string(hex("00 00 00 00  00 00 00 03 61 62 00"));
    ASSERT_TRUE(text);
    EXPECT_EQ(*text, "ab");
    EXPECT_EQ(read_string(hex("00 01 00 00  03 00 00 00 61 62 00")), text);
}

TEST(CdrReading, reads_the_axes_of_a_joy) {
    const auto joy = read_joy(
        hex("00 01 00 00  01 00 00 00 02 00 00 00  02 00 00 00 61 00 00 00  02 00 00 00 00 00 80 3F 00 00 00 BF"
            " 00 00 00 00"));
    ASSERT_TRUE(joy);
    EXPECT_EQ(joy->axes, (std::vector<float>{1, -0.5F}));
}

TEST(CdrReading, refuses_what_is_shorter_than_it_states) {
    for (std::size_t size = 0; size < twist.size(); ++size) EXPECT_FALSE(read_twist(ano::Bytes{twist}.first(size))) << size;
    EXPECT_FALSE(read_string(hex("00 01 00 00  FF FF FF FF 61 62 00")));
    EXPECT_FALSE(read_string(hex("00 01 00 00  02 00 00 00 61 62")));    // no NUL
    EXPECT_FALSE(read_joy(hex("00 01 00 00  01 00 00 00 02 00 00 00  01 00 00 00 00 00 00 00  FF FF FF 3F")));
    EXPECT_FALSE(read_twist(hex("00 07 00 00")));    // XCDR2
    EXPECT_FALSE(read_string({}));
}

}    // namespace
}    // namespace cdr_reader_tests
