#include <gateway/frame_key.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

using namespace anogate;

namespace {

std::uint64_t key(const support::Bytes& frame) { return frame_key(ano::FrameView{frame}); }

}    // namespace

TEST(FrameKey, tells_frames_apart) {
    const auto one = support::frame(1, 2, 3, {4});
    EXPECT_EQ(key(one), key(support::frame(1, 2, 3, {4})));
    for (const auto& other : {support::frame(9, 2, 3, {4}), support::frame(1, 9, 3, {4}), support::frame(1, 2, 9, {4}),
                              support::frame(1, 2, 3, {9}), support::frame(1, 2, 3, {4, 0}), support::frame(1, 2, 3, {})})
        EXPECT_NE(key(one), key(other));
}
