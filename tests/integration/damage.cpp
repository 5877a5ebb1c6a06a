// Bad input through the whole gateway: noise, false headers, damaged and oversized frames.
#include <support/pty_device.hpp>
#include <support/random.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

namespace damage_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

struct Pair {
    explicit Pair(std::uint16_t max_data = 4096) {
        auto a_link = serial("a", a.path()), b_link = serial("b", b.path());
        a_link.max_data = b_link.max_data = max_data;
        a_link.queue = b_link.queue = std::max(32u * 1024, 2u * max_data);
        daemon.emplace(settings_of({a_link, b_link}));
        if (!daemon->until_up("a") || !daemon->until_up("b")) throw std::runtime_error{"no ptys"};
    }
    /// Waits until everything is read; meanwhile reads b.
    bool send(std::span<const std::uint8_t> bytes) {
        said += bytes.size();
        return daemon->until(
            [&] {
                bytes = bytes.subspan(a.write(bytes));
                b.heard();
                return bytes.empty() && daemon->count("a", "bytes_in") == said;
            },
            30s);
    }
    TempDir dir;
    PtyDevice a{dir / "a"}, b{dir / "b"};
    std::optional<RunningGateway> daemon;
    std::size_t said = 0;
};

TEST(Damage, a_false_header_does_not_lose_the_eight_good_frames_after_it) {
    Pair pair;
    Bytes expected;
    for (std::uint8_t round = 0; round < 80; ++round) {
        Bytes good;
        for (std::uint8_t n = 0; n < 8; ++n) good = good + frame(0xDC, 0xFE, 0x03, {n, round, 0, 0, 0, 0, 0});
        expected = expected + good;
        ASSERT_TRUE(pair.send(hex("AB DC FE 01 FF 00") + good));
        ASSERT_TRUE(pair.daemon->until([&] { return pair.b.heard().size() == expected.size(); })) << "round " << int{round};
    }
    EXPECT_EQ(pair.b.heard(), expected);
}

TEST(Damage, a_false_header_in_a_steady_stream_delays_frames_for_less_than_two_seconds) {
    Pair pair;
    ASSERT_TRUE(pair.send(hex("AB DC FE 01 FF 0F")));
    const auto begin = anogate::Clock::now();
    Bytes expected;
    bool through = false;
    for (std::uint8_t n = 0; n < 250 && !through; ++n) {    // a frame every 10 ms: the line is never quiet for 50 ms
        const Bytes good = frame(0xDC, 0xFE, 0x03, {n, 0, 0, 0, 0, 0, 0});
        expected = expected + good;
        ASSERT_TRUE(pair.send(good));
        pair.daemon->run_for(10ms);
        through = !pair.b.heard().empty();
    }
    EXPECT_TRUE(through);
    EXPECT_LT(anogate::Clock::now() - begin, 2s);
    EXPECT_TRUE(pair.daemon->until([&] { return pair.b.heard() == expected; }));
}

TEST(Damage, a_mebibyte_of_noise_is_not_forwarded_and_adds_no_route) {
    Pair pair;
    Random random{7};
    Bytes noise(1 << 20);
    for (auto& byte : noise) byte = random.byte();
    ASSERT_TRUE(pair.send(noise));
    EXPECT_EQ(pair.daemon->count("a", "frames_in"), 0u) << "this noise holds no frame by chance";
    EXPECT_TRUE(pair.daemon->status().at("routes").empty());
    EXPECT_GT(pair.daemon->count("a", "bad_check"), 0u);
    EXPECT_GT(pair.daemon->count("a", "bad_length"), 0u);
    ASSERT_TRUE(pair.send(vendor::i_am_an_mcu));
    EXPECT_TRUE(pair.daemon->until([&] { return pair.b.heard() == vendor::i_am_an_mcu; }));
    EXPECT_EQ(pair.daemon->count("a", "skipped_bytes"), noise.size());
}

TEST(Damage, one_wrong_bit_loses_only_one_frame) {
    Pair pair;
    Random random{1};
    Bytes stream, expected;
    for (std::uint8_t n = 0; n < 100; ++n) {
        Bytes next = frame(0xDC, 0xFE, 0x03, {n, 1, 2, 3, 4, 5, 6});
        if (n % 5 == 4) next[random.below(next.size())] ^= static_cast<std::uint8_t>(1 << random.below(8));
        else expected = expected + next;
        stream = stream + next;
    }
    ASSERT_TRUE(pair.send(stream));
    EXPECT_TRUE(pair.daemon->until([&] { return pair.b.heard().size() >= expected.size(); }));
    EXPECT_EQ(pair.b.heard(), expected);
}

TEST(Damage, the_largest_possible_frame_passes_where_it_is_allowed) {
    Pair pair{65535};
    Bytes data(65535);
    Random random{3};
    for (auto& byte : data) byte = random.byte();
    const Bytes image = frame(0xDF, 0xFE, 0xB0, data);
    ASSERT_TRUE(pair.send(image));
    EXPECT_TRUE(pair.daemon->until([&] { return pair.b.heard().size() == image.size(); }));
    EXPECT_TRUE(pair.b.heard() == image);
}

TEST(Damage, a_frame_longer_than_allowed_is_rejected_by_its_header) {
    Pair pair{200};
    ASSERT_TRUE(pair.send(frame(0xDF, 0xFE, 0xB0, Bytes(201, 0)) + vendor::i_am_an_mcu));
    EXPECT_TRUE(pair.daemon->until([&] { return pair.b.heard() == vendor::i_am_an_mcu; }));
    EXPECT_EQ(pair.daemon->count("a", "bad_length"), 1u);
}

TEST(Damage, the_start_of_a_frame_before_an_unplug_is_not_joined_to_bytes_after_it) {
    Pair pair;
    ASSERT_TRUE(pair.send(std::span{vendor::i_am_an_mcu}.first(12)));
    pair.a.unplug();
    ASSERT_TRUE(pair.daemon->until_waiting("a"));
    pair.a.plug();
    ASSERT_TRUE(pair.daemon->until_up("a"));
    ASSERT_TRUE(pair.send(std::span{vendor::i_am_an_mcu}.subspan(12)));
    ASSERT_TRUE(pair.send(vendor::written));
    EXPECT_TRUE(pair.daemon->until([&] { return pair.b.heard() == vendor::written; }));
}

}    // namespace
}    // namespace damage_tests
