#include <gateway/ring_watch.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace ring_watch_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

constexpr TimePoint start{1h};
constexpr ChannelId a{1}, b{2}, cable{3};

RingWatch watch(std::uint64_t station) {
    RingWatch rings{station};
    rings.open(a, LinkId{11}, true);
    rings.open(b, LinkId{12}, true);
    rings.open(cable, LinkId{13}, false);
    return rings;
}
support::Bytes bytes_of(ano::FrameView frame) { return {frame.bytes().begin(), frame.bytes().end()}; }
using Probe = RingWatch::Probe;

TEST(RingWatch, asks_in_a_frame_that_every_bridge_forwards) {
    RingWatch rings = watch(1);
    const auto probe = bytes_of(rings.ask(a, start));
    ASSERT_TRUE(ano::frame_at(probe));
    EXPECT_TRUE(is_probe(ano::FrameView{probe}));
    EXPECT_EQ((std::array{probe[1], probe[2], probe[3]}), (std::array<std::uint8_t, 3>{0xFE, 0xFF, 0xFB}));
    EXPECT_NE(bytes_of(rings.ask(a, start)), probe);
    EXPECT_FALSE(is_probe(ano::FrameView{support::frame(0xFE, 0xFF, 0xFB, {1, 2, 3})})) << "somebody's own 0xFB";
    auto data = support::Bytes(probe.begin() + 6, probe.end() - 2);
    EXPECT_FALSE(is_probe(ano::FrameView{support::frame(0xDC, 0xFF, 0xFB, data)}));
    data[0] = 'X';
    EXPECT_FALSE(is_probe(ano::FrameView{support::frame(0xFE, 0xFF, 0xFB, data)}));
}

TEST(RingWatch, its_answer_names_the_links) {
    RingWatch rings = watch(1);
    const auto probe = bytes_of(rings.ask(a, start));
    EXPECT_FALSE(rings.ring(a, start));
    EXPECT_EQ(rings.take(ano::FrameView{probe}, b, start + 1s), Probe::ours) << "late, but it tells";
    for (const ChannelId channel : {a, b}) {
        ASSERT_TRUE(rings.ring(channel, start + 60s)) << "for a minute";
        EXPECT_EQ(rings.ring(channel, start + 1s)->out, LinkId{11});
        EXPECT_EQ(rings.ring(channel, start + 1s)->back, LinkId{12});
        EXPECT_FALSE(rings.ring(channel, start + 61s));
        EXPECT_FALSE(rings.is_ring(channel, start + 61s));
        EXPECT_FALSE(rings.rings().contains(channel)) << "nor counted among them when that was found";
    }
}

TEST(RingWatch, an_old_answer_and_a_made_up_one_tell_nothing) {
    RingWatch rings = watch(1);
    const auto old = bytes_of(rings.ask(a, start));
    for (int i = 1; i <= 8; ++i) rings.ask(a, start + i * 1s);
    rings.take(ano::FrameView{old}, b, start + 8s);
    auto data = support::Bytes(old.begin() + 6, old.end() - 2);
    data[16] = static_cast<std::uint8_t>(b);    // which was never asked
    for (int question = 0; question < 256; ++question) {
        data[12] = static_cast<std::uint8_t>(question);
        rings.take(ano::FrameView{support::frame(0xFE, 0xFF, 0xFB, data)}, b, start + 1s);
    }
    EXPECT_FALSE(rings.ring(a, start + 8s) || rings.ring(b, start + 8s));
}

TEST(RingWatch, an_answer_counts_though_the_next_question_is_out) {
    RingWatch rings = watch(1);
    const auto slow = bytes_of(rings.ask(a, start));
    rings.ask(a, start + 1s);
    EXPECT_EQ(rings.take(ano::FrameView{slow}, b, start + 1500ms), Probe::ours);
    EXPECT_TRUE(rings.ring(a, start + 1500ms));
}

TEST(RingWatch, a_channel_may_no_longer_be_asked_when_it_is_opened_as_a_cable) {
    RingWatch rings = watch(1);
    rings.open(a, LinkId{11}, false);
    EXPECT_FALSE(rings.is_probed(a));
    EXPECT_FALSE(rings.is_due(a, start));
}

TEST(RingWatch, another_gateways_question_goes_on_once) {
    RingWatch rings = watch(1), other = watch(2);
    const auto probe = bytes_of(other.ask(a, start));
    EXPECT_EQ(rings.take(ano::FrameView{probe}, a, start), Probe::news);
    EXPECT_EQ(rings.take(ano::FrameView{probe}, b, start + 1s), Probe::known);
    EXPECT_EQ(rings.take(ano::FrameView{bytes_of(other.ask(a, start + 1s))}, a, start + 1s), Probe::news);
    EXPECT_FALSE(rings.ring(a, start + 1s));
}

TEST(RingWatch, asks_once_a_second_and_never_by_a_cable) {
    RingWatch rings = watch(1);
    EXPECT_TRUE(rings.is_due(a, start));
    rings.ask(a, start);
    EXPECT_FALSE(rings.is_due(a, start + 999ms));
    EXPECT_TRUE(rings.is_due(a, start + 1s));
    EXPECT_FALSE(rings.is_due(a, start + 1s, RingWatch::calm));
    EXPECT_TRUE(rings.is_due(b, start)) << "each for itself";
    EXPECT_FALSE(rings.is_due(cable, start));
}

TEST(RingWatch, silence_is_an_answer_for_a_while) {
    RingWatch rings = watch(1);
    rings.ask(a, start);
    EXPECT_TRUE(rings.is_asking(start));
    EXPECT_FALSE(rings.is_clear(a, start + RingWatch::patience - 1ms));
    EXPECT_TRUE(rings.is_clear(a, start + RingWatch::patience));
    EXPECT_FALSE(rings.is_clear(a, start + 60s));
    rings.ask(a, start + 59s);
    EXPECT_TRUE(rings.is_clear(a, start + 59s)) << "asked again, it is clear all the while";
    EXPECT_FALSE(rings.is_asking(start + 59s)) << "and nobody has to wait";
}

TEST(RingWatch, a_cable_is_judged_by_what_comes_back) {
    RingWatch rings = watch(1);
    rings.spread(cable, start);
    EXPECT_FALSE(rings.is_clear(cable, start + 500ms));
    rings.brought_back(cable, true, start, start + 500ms);
    EXPECT_FALSE(rings.is_clear(cable, start + 3s));
    for (int i = 0; i < 4; ++i) rings.spread(cable, start + 10s);
    rings.brought_back(cable, true, start + 10s, start + 10s);
    EXPECT_TRUE(rings.is_clear(cable, start + 13s));
    EXPECT_FALSE(rings.ring(cable, start + 13s));
    rings.brought_back_ones_own(cable, start + 14s);
    EXPECT_TRUE(rings.ring(cable, start + 14s));
    EXPECT_FALSE(rings.is_clear(cable, start + 14s));
}

TEST(RingWatch, a_cable_that_brings_back_half_of_what_hosts_say_is_clear_for_a_minute) {
    RingWatch rings = watch(1);
    for (int i = 0; i < 4; ++i) rings.spread(cable, start);
    for (int i = 0; i < 2; ++i) rings.brought_back(cable, true, start, start);
    EXPECT_TRUE(rings.is_clear(cable, start + 3s));
    EXPECT_TRUE(rings.is_clear(cable, start + 3s + RingWatch::holds - 1ms));
    EXPECT_FALSE(rings.is_clear(cable, start + 3s + RingWatch::holds));
}

TEST(RingWatch, what_came_back_by_a_cable_counts_for_what_was_spread_at_that_time) {
    RingWatch rings = watch(1);
    for (int i = 0; i < 4; ++i) rings.spread(cable, start);
    for (int i = 0; i < 4; ++i) rings.brought_back(cable, true, start, start);
    for (int i = 0; i < 4; ++i) rings.spread(cable, start + 10s);
    EXPECT_FALSE(rings.is_clear(cable, start + 10s));
    EXPECT_TRUE(rings.is_clear(cable, start + 13s)) << "nothing of the last four came back";
}

TEST(RingWatch, what_devices_say_counts_once) {
    RingWatch rings = watch(1);
    for (std::uint32_t i = 0; i < RingWatch::telling / 2; ++i) rings.told(cable, start);
    for (int i = 1; i <= 10; ++i) EXPECT_FALSE(rings.is_clear(cable, start + i * 3s)) << i;
}

TEST(RingWatch, a_cable_that_brings_back_nothing_of_what_devices_say_is_clear) {
    RingWatch rings = watch(1);
    for (int i = 0; i < 20; ++i) {
        rings.told(ChannelSet{a} | cable, start + i * 200ms);
        EXPECT_EQ(rings.is_clear(cable, start + i * 200ms), i * 200ms >= 3s)
            << i << ": eight of which none can still be on its way";
    }
    EXPECT_FALSE(rings.is_clear(a, start + 4s)) << "it is to be asked";
    EXPECT_TRUE(rings.is_clear(cable, start + 60s));
    rings.brought_back_ones_own(cable, start + 60s);
    EXPECT_FALSE(rings.is_clear(cable, start + 63s)) << "all of that no longer counts";
    rings.told(cable, start + 64s);
    EXPECT_FALSE(rings.is_clear(cable, start + 67s)) << "eight more are needed";
}

TEST(RingWatch, more_than_a_thousand_in_one_second_are_a_ring) {
    RingWatch rings = watch(1);
    for (int second = 0; second < 3; ++second)
        for (std::uint32_t n = 0; n < RingWatch::storm; ++n)
            ASSERT_FALSE(rings.brought_back(a, true, start, start + second * 1s)) << second << " s, " << n;
    EXPECT_FALSE(rings.ring(a, start + 2s));
    EXPECT_TRUE(rings.brought_back(a, true, start, start + 2s));
    EXPECT_TRUE(rings.ring(a, start + 2s));
}

}    // namespace
}    // namespace ring_watch_tests
