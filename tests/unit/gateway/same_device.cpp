#include <gateway/same_device.hpp>

#include <gtest/gtest.h>

namespace same_device_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr LinkId a{1}, b{2};
constexpr std::uint8_t source = 0xDC;

// The frames of one source on two links for `time`, one every `every`; b's frames arrive `later`.
struct TwoLinks {
    SameDevice device;
    ano::TimePoint now{1h};
    int met = 0;

    void run(ano::Duration time, ano::Duration every, ano::Duration later, bool same, bool at_rest = false) {
        const auto start = now;
        for (std::uint64_t n = 1; now < start + time; ++n) {
            const auto next = now + every;
            const std::uint64_t key = at_rest ? 7 : n;
            met += device.heard(source, a, key, now).has_value();
            now += later;
            const auto other = device.heard(source, b, same ? key : key + 1'000'000, now);
            if (other) {
                EXPECT_EQ(*other, a);
            }
            met += other.has_value();
            now = next;
        }
    }
};

TEST(SameDevice, is_recognized_when_both_links_receive_equal_frames) {
    for (const auto later : {0ms, 1ms, 10ms, 19ms, 100ms}) {
        TwoLinks links;
        if (later < 20ms) {
            links.run(20s, 20ms, later, true);
        } else {    // the next frames arrive meanwhile
            for (std::uint64_t n = 5; n < 1000; ++n) {
                links.met += links.device.heard(source, a, n, links.now).has_value();
                links.met += links.device.heard(source, b, n - 5, links.now).has_value();
                links.now += later / 5;
            }
        }
        EXPECT_GE(links.met, 8) << later.count();
        EXPECT_FALSE(links.device.differ(source)) << later.count();
    }
}

TEST(SameDevice, is_recognized_by_one_equal_frame_on_both_links) {
    TwoLinks links;
    EXPECT_EQ(links.device.heard(source, a, 1, links.now), std::nullopt);
    EXPECT_EQ(links.device.heard(source, a, 1, links.now), std::nullopt) << "said twice by one link";
    EXPECT_EQ(links.device.heard(source + 1, b, 1, links.now), std::nullopt);
    EXPECT_FALSE(links.device.met(source));
    EXPECT_EQ(links.device.heard(source, b, 1, links.now + SameDevice::window - 1ms), a);
    EXPECT_TRUE(links.device.met(source));
    EXPECT_EQ(links.device.heard(source, b, 1, links.now + SameDevice::window), std::nullopt) << "too late";
}

TEST(SameDevice, reports_two_devices_as_different) {
    TwoLinks links;
    links.run(1500ms, 20ms, 7ms, false);
    EXPECT_FALSE(links.device.differ(source)) << "too early to tell";
    links.run(1s, 20ms, 7ms, false);
    EXPECT_TRUE(links.device.differ(source));
    EXPECT_EQ(links.met, 0);
    links.run(30s, 20ms, 7ms, true);
    EXPECT_FALSE(links.device.differ(source)) << "one was taken away, and the other got a second cable";
}

TEST(SameDevice, constant_samples_count_only_in_the_first_window) {
    TwoLinks links;
    links.run(30s, 20ms, 7ms, true, true);
    EXPECT_LE(links.met, 25) << "the frames of the first window";
    EXPECT_FALSE(links.device.differ(source));
}

TEST(SameDevice, finds_no_second_device_on_one_link_alone) {
    TwoLinks links;
    for (std::uint64_t n = 0; n < 10000; ++n, links.now += 10ms) links.device.heard(source, a, n, links.now);
    EXPECT_FALSE(links.device.differ(source));
}

TEST(SameDevice, does_not_compare_with_a_removed_link) {
    TwoLinks links;
    links.run(3s, 20ms, 7ms, false);
    EXPECT_TRUE(links.device.differ(source));
    links.device.remove_link(LinkId{40});
    EXPECT_TRUE(links.device.differ(source)) << "another";
    links.device.remove_link(b);
    EXPECT_FALSE(links.device.differ(source));
    EXPECT_FALSE(links.device.heard(source, b, 7, links.now));
    links.device.remove_link(b);
    EXPECT_FALSE(links.device.heard(source, a, 7, links.now)) << "the sample was of the other";
}

}    // namespace
}    // namespace same_device_tests
