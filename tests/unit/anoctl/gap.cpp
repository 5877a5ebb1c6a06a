#include <gtest/gtest.h>
#include <anoctl/recording/gap.hpp>

#include <string>

#include <support/bytes.hpp>

namespace gap_tests {
namespace {

using namespace anoctl;
using support::Bytes;
using support::hex;

/// "3 11! 2": sizes; ! marks a frame with wrong check bytes.
std::string parts(const Bytes& gap) {
    std::string text;
    for (const GapPart& part : parts_of(gap))
        text += (text.empty() ? "" : " ") + std::to_string(part.bytes.size()) + (part.right ? "!" : "");
    return text;
}

const std::string frame = "ABFEFFE00300000000AAAA";

TEST(Gap, recognizes_a_frame_with_a_wrong_checksum_by_its_position) {
    EXPECT_EQ(parts({}), "");
    EXPECT_EQ(parts(hex("01 02")), "2");
    EXPECT_EQ(parts(hex(frame)), "11!");
    EXPECT_EQ(parts(hex(frame + frame + "00")), "11! 11! 1");
    EXPECT_EQ(parts(hex("0000" + frame + frame)), "2 11! 11!");
    EXPECT_EQ(parts(hex(frame + "AB" + frame)), "11! 1 11!");
    EXPECT_EQ(parts(hex("00" + frame + "00")), "13") << "it may be anything";
    EXPECT_EQ(parts(hex(frame.substr(0, 20))), "10") << "its end is not there";
}

TEST(Gap, takes_linear_time) {
    Bytes gap{0};
    for (int i = 0; i < 100'000; ++i)
        for (const std::uint8_t byte : hex("ABFEFF0000000000")) gap.push_back(byte);
    gap.push_back(0);
    EXPECT_EQ(parts_of(gap).size(), 1u);
}

}    // namespace
}    // namespace gap_tests
