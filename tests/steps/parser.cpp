// Any input costs linear time: counted in steps, which a busy machine does not change.
#include "steps.hpp"

#include <ano/parser.hpp>
#include <ano/v7.hpp>
#include <support/crafted.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

using support::Bytes;
using support::Random;

namespace {

// Input is several times as long as the largest frame, so that work which grows by frame length shows: a parser that
// sums up every candidate anew takes hundreds of steps a byte.
constexpr std::size_t input_size = 300'000;
constexpr double steps_a_byte = 30;
constexpr double steps_a_read = 70;

// Of what is allowed, the share that was needed.
template <class Parser>
double share_of(Parser& parser, const Bytes& input, std::size_t read_size) {
    ano::TimePoint now{};
    const std::uint64_t before = support::steps;
    for (std::size_t at = 0; at < input.size();) {
        const auto room = parser.prepare();
        const std::size_t n = std::min({room.size(), read_size, input.size() - at});
        std::memcpy(room.data(), input.data() + at, n);
        parser.commit(n, now);
        while (parser.next()) {}
        at += n;
    }
    // The line falls silent: what still waits is given up, one candidate's time after the other.
    while (const auto due = parser.deadline()) {
        now = *due;
        while (parser.expire(now))
            while (parser.next()) {}
    }
    const auto bytes = static_cast<double>(input.size());
    const double allowed = steps_a_byte * bytes + steps_a_read * std::ceil(bytes / static_cast<double>(read_size));
    return static_cast<double>(support::steps - before) / allowed;
}

double share(const Bytes& input, std::size_t max_data, std::size_t read_size) {
    ano::FrameParser parser{{.max_data = max_data}};
    return share_of(parser, input, read_size);
}

class AnyRead : public testing::TestWithParam<std::size_t> {};    // bytes a read

TEST_P(AnyRead, of_crafted_input_costs_linear_time) {
    double most = 0;
    for (const auto& crafted : support::crafted()) {
        const double needed = share(support::input_of(crafted.piece, input_size), crafted.max_data, GetParam());
        EXPECT_LT(needed, 1) << crafted.name;
        EXPECT_GT(needed, 0.001) << crafted.name << ": nothing was counted";
        most = std::max(most, needed);
    }
    RecordProperty("most", std::to_string(most));
}

TEST_P(AnyRead, of_any_short_pattern_costs_linear_time) {
    double most = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        Random random{seed};
        Bytes pattern(1 + random.below(16u));
        for (auto& byte : pattern) byte = random.of<std::uint8_t>({ano::head, ano::head, ano::head, 0, 1, random.byte()});
        const std::size_t max_data = random.of<std::size_t>({198, 4096, 65535});
        const double needed = share(support::input_of(support::repeat(pattern), input_size), max_data, GetParam());
        EXPECT_LT(needed, 1) << "seed " << seed;
        most = std::max(most, needed);
    }
    RecordProperty("most", std::to_string(most));
}

TEST_P(AnyRead, of_input_crafted_for_the_search_of_two_frames_in_a_row_costs_linear_time) {
    double most = 0;
    for (const auto& crafted : support::crafted_for_pairs()) {
        const double needed = share(support::input_of(crafted.piece, input_size), crafted.max_data, GetParam());
        EXPECT_LT(needed, 1) << crafted.name;
        most = std::max(most, needed);
    }
    RecordProperty("most", std::to_string(most));
}

TEST_P(AnyRead, of_v7_costs_linear_time) {
    double most = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        Random random{seed};
        Bytes pattern(1 + seed / 4);
        for (auto& byte : pattern)
            byte = random.of<std::uint8_t>({ano::v7::head, ano::v7::head, ano::v7::head, 0, 255, random.byte()});
        if (seed < 4) pattern = {ano::v7::head};
        ano::v7::FrameParser parser{{}};
        const double needed = share_of(parser, support::input_of(support::repeat(pattern), input_size), GetParam());
        EXPECT_LT(needed, 1) << "seed " << seed;
        EXPECT_GT(needed, 0.001) << "seed " << seed << ": nothing was counted";
        most = std::max(most, needed);
    }
    RecordProperty("most", std::to_string(most));
}

INSTANTIATE_TEST_SUITE_P(bytes, AnyRead, testing::Values(1, 61, 4096),
                         [](const auto& test) { return std::to_string(test.param); });

}    // namespace
