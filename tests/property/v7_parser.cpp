// The parser of V7 compared with a reference that is simple enough to be right.
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_reference_parser.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

namespace v7_parser_tests {

using namespace std::chrono_literals;
using support::Bytes;
using support::Random;
namespace v7 = ano::v7;

namespace {

Bytes random_frame(Random& random, std::size_t max_data) {
    Bytes data(random.below(random.one_in(4) ? max_data + 1 : std::min<std::size_t>(max_data, 20) + 1));
    for (auto& byte : data) byte = random.one_in(6) ? v7::head : random.byte();
    return support::v7_frame(random.of<std::uint8_t>({0xFF, 0xAF, v7::head, random.byte()}), random.byte(), data);
}

Bytes random_piece(Random& random, std::size_t max_data) {
    Bytes bytes;
    switch (random.below(7u)) {
    case 0:
        bytes.resize(random.below(60u));
        for (auto& byte : bytes) byte = random.byte();
        return bytes;
    case 1:
        bytes = random_frame(random, max_data);
        bytes[random.below(bytes.size())] ^= static_cast<std::uint8_t>(1u << random.below(8u));
        return bytes;
    case 2:
        bytes = random_frame(random, max_data);
        bytes.resize(random.below(bytes.size()));
        return bytes;
    case 3: return {v7::head, random.byte(), random.byte(), random.byte()};
    case 4:
        bytes.assign(random.below(300u), v7::head);
        for (auto& byte : bytes)
            if (random.one_in(5)) byte = random.below(std::uint8_t{4});
        return bytes;
    default: return random_frame(random, max_data);
    }
}

void append(Bytes& to, const Bytes& bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

class AnyV7Input : public testing::TestWithParam<std::size_t> {};    // max_data

TEST_P(AnyV7Input, gives_the_frames_of_the_reference_and_its_counters) {
    for (std::uint64_t seed = 0; seed < support::trials(200); ++seed) {
        Random random{seed};
        const bool datagrams = random.one_in(2);
        support::BothV7Parsers both{{.max_data = GetParam(), .quiet = random.of<ano::Duration>({20ms, 20ms, 5ms, 300ms})}};
        for (int step = 0; step < 80 && both.difference.empty(); ++step) {
            Bytes bytes = random_piece(random, GetParam());
            while (!random.one_in(3)) append(bytes, random_piece(random, GetParam()));
            if (datagrams) {
                both.feed_datagram(bytes);
            } else {
                for (std::span<const std::uint8_t> rest{bytes}; !rest.empty();) {
                    const std::size_t n = std::min(rest.size(), 1 + random.below(random.of<std::size_t>({1, 7, 70, 5000})));
                    both.put(rest.first(n));
                    rest = rest.subspan(n);
                    if (random.one_in(20)) both.expire();
                }
            }
            both.now += random.of<ano::Duration>({0ms, 1ms, 5ms, 19ms, 20ms, 99ms, 100ms, 200ms, 1100ms});
            if (random.one_in(3)) both.expire();
            if (random.one_in(40)) both.finish();
        }
        both.finish();
        ASSERT_EQ(both.difference, "") << "seed " << seed;
        ASSERT_FALSE(both.frames().empty()) << "seed " << seed;
    }
}

INSTANTIATE_TEST_SUITE_P(max_data, AnyV7Input, testing::Values(0, 1, 44, 254, 255),
                         [](const auto& test) { return std::to_string(test.param); });

// A line without pauses: every whole frame is found, whatever damaged frames are between.
TEST(V7Parser, finds_every_frame_between_damaged_ones) {
    for (std::uint64_t seed = 0; seed < support::trials(200); ++seed) {
        Random random{seed};
        support::BothV7Parsers both{{}};
        Bytes line;
        std::size_t sent = 0;
        for (int i = 0; i < 50; ++i) {
            Bytes damaged = random_frame(random, 40);
            for (auto& byte : damaged)
                if (byte == v7::head) byte = 0;
            damaged[0] = random.one_in(2) ? v7::head : std::uint8_t{0};
            if (damaged.size() > 6) damaged.resize(damaged.size() - 1 - random.below(3u));
            append(line, damaged);
            Bytes data(random.below(60u));
            for (auto& byte : data) byte = static_cast<std::uint8_t>(random.below(100u));
            append(line, support::v7_frame(0xAF, 0x0D, data));
            ++sent;
        }
        both.put(line);
        both.finish();
        ASSERT_EQ(both.difference, "") << "seed " << seed;
        // A damaged frame may by chance have right checks over bytes of the next one.
        EXPECT_GE(both.frames().size() + 1, sent) << "seed " << seed;
    }
}

}    // namespace
}    // namespace v7_parser_tests
