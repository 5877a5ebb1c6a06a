#include <ano_json/split_frames.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <string>

namespace split_frames_tests {
namespace {

using support::Bytes;
using support::operator+;

/// "6 [20] 1": the sizes of gaps and frames.
std::string parts(const Bytes& bytes) {
    std::string text;
    std::size_t end = 0;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : " ") + part; };
    ano::split_frames(
        bytes,
        [&](ano::FrameView frame) {
            add("[" + std::to_string(frame.bytes().size()) + "]");
            end += frame.bytes().size();
        },
        [&](std::size_t at, std::span<const std::uint8_t> gap) {
            EXPECT_EQ(at, end);
            add(std::to_string(gap.size()));
            end += gap.size();
        });
    EXPECT_EQ(end, bytes.size());
    return text;
}

TEST(SplitFrames, returns_frames_and_the_bytes_between_them) {
    const Bytes frame = support::frame(0xDC, 0xFE, 0x01, Bytes(12));
    EXPECT_EQ(parts({}), "");
    EXPECT_EQ(parts(frame + frame), "[20] [20]");
    EXPECT_EQ(parts(Bytes{1, 2} + frame + Bytes{3} + frame + Bytes{4}), "2 [20] 1 [20] 1");
}

TEST(SplitFrames, finds_a_frame_after_a_header_whose_frame_would_exceed_the_bytes) {
    EXPECT_EQ(parts(Bytes{ano::head, 0xDC, 0xFE, 0x01, 20, 0} + support::frame(0xDC, 0xFE, 0x01, Bytes(12))), "6 [20]");
}

}    // namespace
}    // namespace split_frames_tests
