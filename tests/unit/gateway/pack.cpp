#include <gateway/pack.hpp>

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace pack_tests {

using namespace anogate;

namespace {

std::size_t packed(std::initializer_list<std::size_t> sizes, std::size_t mtu) {
    static constexpr std::array<std::uint8_t, 2000> bytes{};
    std::vector<std::span<const std::uint8_t>> frames;
    for (const std::size_t size : sizes) frames.push_back(std::span{bytes}.first(size));
    return frames_in_datagram(frames, mtu);
}

TEST(Pack, contains_as_many_whole_frames_as_fit) {
    EXPECT_EQ(packed({400, 400, 400, 400}, 1400), 3u);
    EXPECT_EQ(packed({400, 400, 400, 200, 8}, 1400), 4u);
    EXPECT_EQ(packed({400, 400}, 1400), 2u);
    EXPECT_EQ(packed({400, 1200, 8}, 1400), 1u) << "in order: a smaller one behind does not overtake";
}

TEST(Pack, contains_at_least_one_frame) {
    EXPECT_EQ(packed({1500, 8}, 1400), 1u);
    EXPECT_EQ(packed({8, 8}, 0), 1u);
    EXPECT_EQ(packed({}, 1400), 0u);
}

}    // namespace
}    // namespace pack_tests
