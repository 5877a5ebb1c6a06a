#include <ano/frame.hpp>
#include <ano/prefix_sums.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

using ano::PrefixSums;
using support::Bytes;

namespace prefix_sums_tests {
namespace {

Bytes random_bytes(std::size_t n) {
    support::Random random{n};
    Bytes bytes(n);
    for (auto& byte : bytes) byte = random.byte();
    return bytes;
}

// Compares every range of [begin, end of the sums) with the plain checks; `bytes` are those from which the sums were made.
void expect_the_checks_of(const Bytes& bytes, const PrefixSums& sums, std::size_t begin) {
    for (std::size_t from = begin; from < sums.end(); from += 7) {
        for (std::size_t to = from; to < sums.end(); ++to) {
            const auto checks = ano::checks_of(std::span{bytes}.subspan(from, to - from));
            ASSERT_EQ(sums.sum_holds(from, to), checks.sum == bytes[to]) << from << " to " << to;
            ASSERT_EQ(sums.add(from, to), checks.add) << from << " to " << to;
        }
    }
}

TEST(PrefixSums, return_the_checksums_of_any_range_for_any_start) {
    const Bytes bytes = random_bytes(400);
    for (std::size_t begin = 0; begin < 40; ++begin) {
        PrefixSums sums{bytes.size()};
        sums.begin(begin);
        sums.extend(bytes, bytes.size());
        EXPECT_EQ(sums.end(), bytes.size());
        expect_the_checks_of(bytes, sums, begin);
    }
}

TEST(PrefixSums, grow_with_the_received_bytes) {
    const Bytes bytes = random_bytes(400);
    for (const std::size_t step : {1u, 3u, 16u, 17u, 100u}) {
        PrefixSums sums{bytes.size()};
        sums.begin(5);
        for (std::size_t there = 6; there < bytes.size(); there += step)
            sums.extend(std::span{bytes}.first(there), there);    // at most to the end of the available bytes
        expect_the_checks_of(bytes, sums, 5);
    }
}

TEST(PrefixSums, remain_valid_when_the_bytes_are_moved_to_the_front) {
    Bytes bytes = random_bytes(400);
    for (const std::size_t distance : {std::size_t{50}, std::size_t{299}, std::size_t{300}}) {
        PrefixSums sums{bytes.size()};
        sums.begin(20);
        sums.extend(std::span{bytes}.first(300), 300);
        sums.move_front(distance);
        EXPECT_EQ(sums.end(), 300 - distance);
        const Bytes moved{bytes.begin() + static_cast<std::ptrdiff_t>(distance), bytes.end()};
        sums.extend(moved, moved.size());
        expect_the_checks_of(moved, sums, 0);
    }
}

TEST(PrefixSums, restart_when_none_of_their_bytes_are_left) {
    const Bytes bytes = random_bytes(100);
    PrefixSums sums{bytes.size()};
    sums.begin(0);
    sums.extend(std::span{bytes}.first(30), 30);
    sums.move_front(50);
    EXPECT_EQ(sums.end(), 0u);
    sums.extend(bytes, bytes.size());
    expect_the_checks_of(bytes, sums, 0);
}

}    // namespace
}    // namespace prefix_sums_tests
