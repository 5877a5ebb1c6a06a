// The parser compared with a reference that is simple enough to be right, and properties that hold for any input.
#include <support/both_parsers.hpp>
#include <support/bytes.hpp>
#include <support/noisy_line.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <tuple>

namespace parser_tests {

using namespace std::chrono_literals;
using support::BothParsers;
using support::Bytes;
using support::Random;

namespace {

void append(Bytes& to, const Bytes& bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

Bytes random_bytes(Random& random, std::size_t n) {
    Bytes bytes(n);
    for (auto& byte : bytes) byte = random.byte();
    return bytes;
}

// From few values, so that most were received before.
std::uint8_t random_source(Random& random) { return random.of<std::uint8_t>({1, 1, 2, ano::head, random.byte()}); }
std::uint8_t random_id(Random& random) { return random.of<std::uint8_t>({0x01, 0x03, 0x34, 0xA0, 0xB1, random.byte()}); }

Bytes random_frame(Random& random, std::size_t max_data) {
    const std::size_t size = random.below(random.one_in(4) ? max_data + 1 : std::min<std::size_t>(max_data, 30) + 1);
    Bytes data = random_bytes(random, size);
    for (auto& byte : data)
        if (random.one_in(8)) byte = ano::head;
    return support::frame(random_source(random), random.byte(), random_id(random), data);
}

// Input that a line may deliver: valid frames, damaged, truncated and nested ones, false headers, noise, bytes that are nearly
// all HEAD.
Bytes random_piece(Random& random, std::size_t max_data) {
    switch (random.below(9)) {
    case 0: return random_bytes(random, random.below(60u));
    case 1: {
        Bytes bytes = random_frame(random, max_data);
        bytes[random.below(bytes.size())] ^= static_cast<std::uint8_t>(1u << random.below(8u));
        return bytes;
    }
    case 2: {
        Bytes bytes = random_frame(random, max_data);
        bytes.resize(random.below(bytes.size()));
        return bytes;
    }
    case 3: {
        const auto length = random.below(max_data + max_data / 8 + 2);
        return {ano::head,
                random_source(random),
                random.byte(),
                random_id(random),
                static_cast<std::uint8_t>(length),
                static_cast<std::uint8_t>(length >> 8)};
    }
    case 4: {
        Bytes bytes(random.below(40u), ano::head);
        for (auto& byte : bytes)
            if (random.one_in(5)) byte = random.below(std::uint8_t{4});
        return bytes;
    }
    case 5: {
        Bytes inner;
        while (random.below(3u) > 0 && inner.size() < max_data) append(inner, random_frame(random, max_data / 4));
        if (inner.size() > max_data) inner.resize(max_data);
        Bytes bytes = support::frame(random_source(random), 2, random_id(random), inner);
        if (random.one_in(2)) bytes[random.below(bytes.size())] ^= 0x10;
        if (random.one_in(3)) bytes.resize(random.below(bytes.size()) + 1);
        return bytes;
    }
    default: return random_frame(random, max_data);
    }
}

// An image: complete, damaged, truncated, or claimed by a false header.
Bytes random_image(Random& random) {
    const auto color = random.of<std::uint8_t>({0, 0, 1, 6, 7});
    const auto width = random.of<std::uint16_t>({160, 320, 1001, 0, 3}), height = random.of<std::uint16_t>({120, 240, 20, 0});
    const int bits = random.one_in(2) ? (width + 7) / 8 : width / 8;
    const auto row = static_cast<std::size_t>(std::max(1, color == 0 ? int{width} : bits));
    Bytes data(17 + random.below(std::size_t{20'200} / row) * row);
    for (std::size_t i = 17; i < data.size(); ++i) data[i] = random.one_in(20) ? ano::head : random.byte();
    if (random.one_in(3) && data.size() > 1000) {
        const Bytes inner = random_frame(random, 40);
        std::copy(inner.begin(), inner.end(), data.begin() + 500);
        std::copy(inner.begin(), inner.end(), data.begin() + 500 + static_cast<std::ptrdiff_t>(inner.size()));
    }
    const Bytes head{1,
                     0,
                     color,
                     static_cast<std::uint8_t>(width),
                     static_cast<std::uint8_t>(width >> 8),
                     static_cast<std::uint8_t>(height),
                     static_cast<std::uint8_t>(height >> 8)};
    std::copy(head.begin(), head.end(), data.begin());
    Bytes bytes = support::frame(random_source(random), random.byte(), 0xB0, data);
    if (random.one_in(4)) bytes[random.below(bytes.size())] ^= 0x04;
    if (random.one_in(3)) bytes.resize(random.below(random.one_in(2) ? 40u : bytes.size()));
    return bytes;
}

// After a valid frame, enough headers to use nearly all credit of the search for two consecutive frames.
Bytes flood(std::size_t max_data) {
    Bytes bytes = support::frame(1, 2, 3, {});
    for (std::size_t heads = 0; heads < 2100; heads += max_data) {
        append(bytes, {ano::head, 0x77, 0, 1, static_cast<std::uint8_t>(max_data), static_cast<std::uint8_t>(max_data >> 8)});
        append(bytes, Bytes(max_data + 2, ano::head));
    }
    return bytes;
}

class AnyInput : public testing::TestWithParam<std::size_t> {};    // max_data

TEST_P(AnyInput, returns_the_frames_and_counters_of_the_reference) {
    const std::size_t max_data = GetParam();
    for (std::uint64_t seed = 0; seed < support::trials(max_data > 1000 ? 60 : 300); ++seed) {
        Random random{seed};
        const bool datagrams = random.one_in(2);
        BothParsers both{{.max_data = max_data,
                          .line_rate = random.of<std::uint32_t>({0, 11520, 50000}),
                          .quiet = random.of<ano::Duration>({50ms, 100ms, 400ms}),
                          .frame_gap = random.of<ano::Duration>({0ms, 0ms, 20ms, 300ms})}};
        if (max_data >= 255 && random.one_in(2)) {
            const Bytes bytes = flood(max_data);
            for (std::span<const std::uint8_t> rest{bytes}; !rest.empty();) {
                const std::size_t n = std::min<std::size_t>(rest.size(), 200);
                both.put(rest.first(n));
                rest = rest.subspan(n);
            }
        }
        for (int step = 0; step < 60 && both.difference.empty(); ++step) {
            Bytes bytes = random_piece(random, max_data);
            while (random.one_in(2)) append(bytes, random_piece(random, max_data));
            if (datagrams) {
                both.feed_datagram(bytes);
            } else {
                std::span<const std::uint8_t> rest{bytes};
                while (!rest.empty()) {
                    const std::size_t n = std::min(rest.size(), 1 + random.below(random.of<std::size_t>({1, 7, 70, 5000})));
                    both.put(rest.first(n));
                    rest = rest.subspan(n);
                    if (random.one_in(20)) both.expire();
                }
            }
            both.now += random.of<ano::Duration>({0ms, 1ms, 20ms, 49ms, 50ms, 99ms, 100ms, 250ms, 1100ms});
            if (random.one_in(3)) both.expire();
            if (random.one_in(40)) both.finish();
        }
        both.finish();
        ASSERT_EQ(both.difference, "") << "seed " << seed;
    }
}

INSTANTIATE_TEST_SUITE_P(max_data, AnyInput, testing::Values(0, 1, 30, 255, 600, 4096),
                         [](const auto& test) { return std::to_string(test.param); });

TEST(FrameParser, finds_images_among_other_frames_as_the_reference_does) {
    std::size_t large = 0;
    for (std::uint64_t seed = 0; seed < support::trials(40); ++seed) {
        Random random{seed};
        BothParsers both{{.line_rate = random.of<std::uint32_t>({0, 11520, 500000})}};
        const bool datagrams = random.one_in(3);
        for (int step = 0; step < 40 && both.difference.empty(); ++step) {
            Bytes bytes = random.one_in(2) ? random_image(random) : random_piece(random, 4096);
            while (random.one_in(2)) append(bytes, random_piece(random, 200));
            if (datagrams) both.feed_datagram(bytes);
            for (std::span<const std::uint8_t> rest{bytes}; !datagrams && !rest.empty();) {
                const std::size_t n = std::min(rest.size(), 1 + random.below(random.of<std::size_t>({30, 700, 5000})));
                both.put(rest.first(n));
                rest = rest.subspan(n);
                if (random.one_in(20)) both.expire();
            }
            both.now += random.of<ano::Duration>({0ms, 1ms, 49ms, 100ms, 1100ms});
            if (random.one_in(3)) both.expire();
        }
        both.finish();
        ASSERT_EQ(both.difference, "") << "seed " << seed;
        for (const Bytes& frame : both.frames()) large += frame.size() > 4104;
    }
    EXPECT_GT(large, 40u);
}

TEST(FrameParser, finds_exactly_the_valid_frames_in_noise_without_headers_however_it_is_split) {
    for (std::uint64_t seed = 0; seed < support::trials(200); ++seed) {
        Random random{seed};
        std::vector<Bytes> sent;
        Bytes line;
        for (int i = 0; i < 50; ++i) {
            Bytes noise = random_bytes(random, random.below(40u));
            for (auto& byte : noise)
                if (byte == ano::head) byte = 0;
            append(line, noise);
            sent.push_back(random_frame(random, 300));
            append(line, sent.back());
        }
        BothParsers both{{}};
        for (std::span<const std::uint8_t> rest{line}; !rest.empty();) {
            const std::size_t n = std::min(rest.size(), 1 + random.below(random.of<std::size_t>({1, 20, 400})));
            both.put(rest.first(n));
            rest = rest.subspan(n);
        }
        ASSERT_EQ(both.difference, "") << "seed " << seed;
        ASSERT_EQ(both.frames(), sent) << "seed " << seed;
    }
}

TEST(FrameParser, finds_in_a_mebibyte_of_random_bytes_only_what_the_reference_finds) {
    // With the default of max_data, and with so many short candidates that a few are frames by chance.
    for (const bool many_candidates : {false, true}) {
        Random random{1};
        BothParsers both{{}};
        for (int i = 0; i < 1024; ++i) {
            Bytes bytes = random_bytes(random, 1024);
            if (many_candidates)
                for (auto& byte : bytes) byte = random.of<std::uint8_t>({ano::head, 0, 0, 1});
            both.put(bytes);
        }
        both.finish();
        ASSERT_EQ(both.difference, "");
        EXPECT_EQ(both.frames().empty(), !many_candidates);
    }
}

// Candidates whose LEN is two HEADs are rejected many at a time; a valid frame may be anywhere among them.
TEST(FrameParser, finds_a_valid_frame_among_heads_as_the_reference_does) {
    constexpr std::size_t length_of_heads = 0xABAB;
    for (const std::size_t max_data : {std::size_t{4096}, length_of_heads - 1, length_of_heads, std::size_t{65535}})
        for (std::uint64_t seed = 0; seed < support::trials(12); ++seed) {
            Random random{seed};
            Bytes bytes(200 + random.below(200u), ano::head);
            for (auto& byte : bytes)
                if (random.one_in(12)) byte = random.byte();
            if (random.one_in(2)) {
                Bytes data(length_of_heads, 0);
                std::fill_n(data.begin(), 100, ano::head);
                const Bytes good = support::frame(ano::head, ano::head, ano::head, data);
                append(bytes, good);
            }
            append(bytes, Bytes(length_of_heads + 500, 0));
            BothParsers both{{.max_data = max_data}};
            both.put(bytes);
            both.finish();
            ASSERT_EQ(both.difference, "") << "max_data " << max_data << ", seed " << seed;
        }
}

// With one false header in 50 frames, or one damaged LEN, 99.5 % of the valid frames are at most 20 ms and two frames late.
class FullLine : public testing::TestWithParam<std::tuple<std::uint32_t, support::Noise>> {};

TEST_P(FullLine, delivers_its_valid_frames_in_time) {
    const auto [baud, noise] = GetParam();
    for (const std::size_t at_once : {16u, 62u}) {
        const support::Delays delays = support::delays_on(
            {.baud = baud, .noise = noise, .noise_one_in = 50, .at_once = at_once, .frames = 10'000});
        EXPECT_EQ(delays.lost, 0u);
        EXPECT_GE(delays.share_in_time(), 0.995) << "the longest took " << delays.longest.count() << " s";
    }
}

INSTANTIATE_TEST_SUITE_P(baud, FullLine,
                         testing::Combine(testing::Values(115200, 500000, 1000000),
                                          testing::Values(support::Noise::random_headers, support::Noise::flipped_len)),
                         [](const auto& test) {
                             return std::to_string(std::get<0>(test.param)) +
                                    (std::get<1>(test.param) == support::Noise::flipped_len ? "_flipped_len" : "_random_headers");
                         });

}    // namespace
}    // namespace parser_tests
