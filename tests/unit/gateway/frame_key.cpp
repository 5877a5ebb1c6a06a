#include <gateway/frame_key.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace frame_key_tests {

using namespace anogate;

namespace {

std::uint64_t key(const support::Bytes& frame) { return frame_key(ano::FrameView{frame}); }

TEST(FrameKey, distinguishes_frames) {
    const auto one = support::frame(1, 2, 3, {4});
    EXPECT_EQ(key(one), key(support::frame(1, 2, 3, {4})));
    for (const auto& other : {support::frame(9, 2, 3, {4}), support::frame(1, 9, 3, {4}), support::frame(1, 2, 9, {4}),
                              support::frame(1, 2, 3, {9}), support::frame(1, 2, 3, {4, 0}), support::frame(1, 2, 3, {})})
        EXPECT_NE(key(one), key(other));
}

TEST(FrameKey, distinguishes_frames_with_equal_checksums) {
    const auto one = support::frame(0xFE, 0xFF, 0xE0, {1, 0, 1, 0, 1});
    const auto other = support::frame(0xFE, 0xFF, 0xE0, {1, 0, 0, 2, 0});
    ASSERT_EQ(ano::FrameView{one}.checks(), ano::FrameView{other}.checks());
    EXPECT_NE(key(one), key(other));
}

TEST(FrameKey, depends_on_every_byte) {
    for (const std::size_t size : {0u, 1u, 7u, 8u, 55u, 56u, 57u, 90u, 300u}) {
        const support::Bytes data(size, 0x55);
        const std::uint64_t before = key(support::frame(1, 2, 3, data));
        for (std::size_t i = 0; i < size; ++i) {
            support::Bytes changed = data;
            changed[i] ^= 0x80;
            EXPECT_NE(key(support::frame(1, 2, 3, changed)), before) << size << " " << i;
        }
    }
}

}    // namespace
}    // namespace frame_key_tests
