// Differences of devices in the field.
#include <gtest/gtest.h>
#include <ano/values.hpp>
#include <device/device.hpp>

#include <string>

#include "talk.hpp"

namespace profile_tests {
namespace {

using ano::FrameView;
using ano::device::Device;
using ano::device::Profile;
using namespace std::chrono_literals;
using namespace talk;
using support::operator+;

// The vendor's profile without its queue, which delays answers.
Profile vendor_at_once() {
    Profile profile = Profile::vendor();
    profile.queue = 0;
    return profile;
}
Profile old_at_once() {
    Profile profile = Profile::old();
    profile.queue = 0;
    return profile;
}

const Bytes read_first = ask(0xE0, {2, 0, 0});

TEST(Profile, vendor_acknowledges_a_parameter_that_it_does_not_have) {
    Device device{{.id = self}, vendor_at_once()};
    std::uint8_t one = 1;
    device.parameters().add("ONE", one);
    const Bytes unknown = ask(0xE1, {2, 0, 9});
    EXPECT_EQ(answer(device, unknown), acknowledges(unknown));
    EXPECT_EQ(one, 1);
    EXPECT_EQ(answer(device, ask(0xE0, {2, 2, 0})), silence) << "a question gets silence";
    EXPECT_EQ(answer(device, ask(0xE0, {3, 2, 0})), silence);
}

TEST(Profile, may_reject_values_that_others_clamp) {
    Device device{{.id = self}, {.refuses_beyond_limits = true}};
    std::uint8_t one = 1;
    std::string name = "ab";
    device.parameters().add("ONE", one, {.max = 5});
    device.parameters().add("NAME", name, {.max_size = 3});
    EXPECT_EQ(answer(device, ask(0xE1, {0, 0, 9})), silence);
    EXPECT_EQ(one, 1);
    EXPECT_NE(answer(device, ask(0xE1, {0, 0, 5})), silence);
    EXPECT_EQ(one, 5);
    EXPECT_EQ(answer(device, ask(0xE1, Bytes{1, 0} + bytes("long"))), silence);
    EXPECT_EQ(name, "ab");
}

TEST(Profile, vendor_stores_the_checksum_in_place_of_missing_bytes) {
    Device device{{.id = self}, vendor_at_once()};
    std::uint32_t wide = 7;
    std::uint16_t of_command = 0;
    device.parameters().add("WIDE", wide);
    device.commands().add({1, 2, 3}, "GO", "", [&](std::uint16_t v) { of_command = v; });
    const Bytes write = ask(0xE1, {0, 0, 0x11});
    EXPECT_EQ(answer(device, write), acknowledges(write));
    const auto checks = FrameView{write}.checks();
    EXPECT_EQ(wide, 0x11u | static_cast<std::uint32_t>(checks.sum) << 8 | static_cast<std::uint32_t>(checks.add) << 16);
    const Bytes command = ask(0xC0, {1, 2, 3});
    EXPECT_EQ(answer(device, command), acknowledges(command));
    EXPECT_EQ(of_command, FrameView{command}.checks().sum | FrameView{command}.checks().add << 8);
}

TEST(Profile, vendor_cuts_a_text_at_29_bytes) {
    Device device{{.id = self}, vendor_at_once()};
    std::string text;
    device.parameters().add("TEXT", text);
    answer(device, ask(0xE1, Bytes{0, 0} + Bytes(60, 'x')));
    EXPECT_EQ(text, std::string(29, 'x'));
}

TEST(Profile, vendor_ignores_frames_that_do_not_fit_its_buffer) {
    Device device{{.id = self}, vendor_at_once()};
    EXPECT_NE(answer(device, ask(0xE0, Bytes(198))), silence);
    EXPECT_EQ(answer(device, ask(0xE0, Bytes(199))), silence);
    EXPECT_EQ(device.counters().too_long, 1u);
}

TEST(Profile, vendor_crashes_on_a_request_for_the_parameter_after_the_last_one) {
    for (const Bytes& last_words : {ask(0xE0, {2, 1, 0}), ask(0xE0, {3, 1, 0}), ask(0xE1, {1, 0, 5})}) {
        Device device{{.id = self}, vendor_at_once()};
        std::uint8_t one = 1;
        device.parameters().add("ONE", one);
        EXPECT_NE(answer(device, read_first), silence);
        EXPECT_EQ(answer(device, last_words), silence);
        EXPECT_TRUE(device.crashed());
        EXPECT_EQ(answer(device, read_first), silence) << "nor anything from then on";
        EXPECT_EQ(device.counters().crashed, 1u);
    }
}

TEST(Profile, vendor_fails_an_image_frame_that_arrives_too_early) {
    Device device{{.id = self}, vendor_at_once()};
    device.firmware().allow({.max_size = 100});
    answer(device, ask(0xF0, Bytes{1, 20, 0, 0, 0, 10, 0} + Bytes(13)));
    answer(device, ask(0xF0, {0, 0x01, 0x10}));
    EXPECT_EQ(answer(device, ask(0xF0, Bytes{0x10, 1, 0} + Bytes(10))), expected_reply(0xF0, {0, 0x10, 0x01, 1, 0}));
    EXPECT_EQ(answer(device, ask(0xF0, Bytes{0x10, 0, 0} + Bytes(10))), expected_reply(0xF0, {0, 0x10, 0x02, 0, 0}));
    EXPECT_EQ(answer(device, ask(0xF0, Bytes{0x10, 1, 0} + Bytes(10))), expected_reply(0xF0, {0, 0x10, 0x02, 1, 0}));
    EXPECT_EQ(answer(device, ask(0xF0, Bytes{0x10, 0, 0} + Bytes(10))), expected_reply(0xF0, {0, 0x10, 0x02, 0, 0})) << "again";
}

TEST(Profile, vendor_queues_twenty_frames_and_silently_drops_further_ones) {
    Device device{{.id = self}, Profile::vendor()};
    std::uint8_t one = 1;
    device.parameters().add("ONE", one);
    for (int i = 0; i < 25; ++i) EXPECT_EQ(answer(device, read_first), silence) << "not yet";
    EXPECT_EQ(device.counters().queue_full, 5u);
    EXPECT_EQ(device.due(), start + 1ms);
    device.run(start + 3ms);
    EXPECT_EQ(heard(device).size(), 3u);
    EXPECT_EQ(device.due(), start + 4ms);
    EXPECT_EQ(all_answers(device, read_first, start + 5ms).size(), 2u) << "and one more waits";
    device.run(start + 1s);
    EXPECT_EQ(heard(device).size(), 16u);
    EXPECT_FALSE(device.due());
    EXPECT_EQ(device.counters().answered, 21u);
}

TEST(Profile, vendor_that_crashed_drops_its_waiting_frames) {
    Device device{{.id = self}, Profile::vendor()};
    const Bytes behind = ask(0xE0, {2, 0, 0});
    device.take(FrameView{behind}, start);
    device.take(FrameView{behind}, start);
    device.run(start + 1s);
    EXPECT_TRUE(device.crashed());
    EXPECT_EQ(device.counters().crashed, 1u);
    EXPECT_TRUE(heard(device).empty());
}

TEST(Profile, vendor_executes_slow_steps_one_after_another) {
    const Bytes accept = ask(0xF0, Bytes{1, 20, 0, 0, 0, 10, 0} + Bytes(13)), erase = ask(0xF0, {0, 0x01, 0x10});
    const Bytes erased = expected_reply(0xF0, {0, 0x01, 0x12});
    for (const bool late : {false, true}) {
        Device device{{.id = self}, Profile::vendor()};
        device.firmware().allow({.max_size = 100, .erase_time = 500us});
        device.take(FrameView{accept}, start);
        device.take(FrameView{erase}, start);
        if (!late) {
            device.run(start + 2ms);
            EXPECT_EQ(heard(device).size(), 1u) << "accepted";
            EXPECT_EQ(device.due(), start + 2ms + 500us);
        }
        device.take(FrameView{read_first}, start + 2ms + 200us);
        EXPECT_EQ(device.due(), start + 2ms + 500us) << "before the next frame is handled";
        device.run(start + 1s);
        const auto frames = heard(device);
        ASSERT_EQ(frames.size(), late ? 2u : 1u);
        EXPECT_EQ(frames.back(), erased);
        EXPECT_FALSE(device.due());
    }
}

TEST(Profile, old_describes_ranges_and_sends_every_value_as_i32) {
    Device device{{.id = self}, old_at_once()};
    float gain = 2.6f;
    std::uint64_t wide = UINT64_MAX;
    std::string text = "text";
    device.parameters().add("GAIN", gain, {.info = "info", .min = -5, .max = 1000});
    device.parameters().add("WIDE", wide);
    device.parameters().add("TEXT", text);
    EXPECT_EQ(answer(device, ask(0xE0, {3, 0, 0})),
              expected_reply(0xE2, Bytes{0, 0, 0xFB, 0xFF, 0xFF, 0xFF, 0xE8, 3, 0, 0} + bytes("GAIN", 20) + bytes("info")));
    EXPECT_EQ(answer(device, ask(0xE0, {3, 1, 0})),
              expected_reply(0xE2, Bytes{1, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0x7F} + bytes("WIDE", 20)));
    for (const std::uint8_t id : Bytes{0, 1, 2}) {
        const Bytes described = answer(device, ask(0xE0, {3, id, 0}));
        EXPECT_TRUE((ano::as<"parameter_info", "old">(FrameView{described}))) << "and is recognised by it";
    }
    EXPECT_EQ(answer(device, read_first), expected_reply(0xE1, {0, 0, 3, 0, 0, 0}));
    EXPECT_EQ(answer(device, ask(0xE0, {2, 1, 0})), expected_reply(0xE1, {1, 0, 0xFF, 0xFF, 0xFF, 0x7F}));
    EXPECT_EQ(answer(device, ask(0xE0, {2, 2, 0})), expected_reply(0xE1, {2, 0, 0, 0, 0, 0}));
    const Bytes write = ask(0xE1, {0, 0, 0xFE, 0xFF, 0xFF, 0xFF});
    EXPECT_EQ(answer(device, write), acknowledges(write));
    EXPECT_EQ(gain, -2);
    answer(device, ask(0xE1, {1, 0, 0xFF, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(wide, 0u) << "the nearest";
    EXPECT_EQ(answer(device, ask(0xE1, Bytes{2, 0, 1, 0, 0, 0})), silence);
    EXPECT_EQ(text, "text");
}

TEST(Profile, scaled_describes_ranges_and_a_factor) {
    Profile profile = Profile::scaled();
    profile.queue = 0;
    Device device{{.id = self}, profile};
    float gain = 2.5f;
    std::uint8_t small = 7;
    std::string text = "text";
    device.parameters().add("GAIN", gain, {.info = "info", .min = -0.5f, .max = 10});
    device.parameters().add("SMALL", small, {.info = "", .min = 1, .max = 9});
    device.parameters().add("TEXT", text);
    EXPECT_EQ(answer(device, ask(0xE0, {3, 0, 0})),
              expected_reply(
                  0xE2, Bytes{0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 10, 0, 0, 0, 0xE8, 3, 0, 0} + bytes("GAIN", 20) + bytes("info")));
    EXPECT_EQ(answer(device, ask(0xE0, {3, 1, 0})),
              expected_reply(0xE2, Bytes{1, 0, 1, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0} + bytes("SMALL", 20)));
    for (const std::uint8_t id : Bytes{0, 1, 2}) {
        const Bytes described = answer(device, ask(0xE0, {3, id, 0}));
        EXPECT_TRUE((ano::as<"parameter_info", "scaled">(FrameView{described}))) << "and is recognised by it";
    }
    EXPECT_EQ(answer(device, read_first), expected_reply(0xE1, {0, 0, 0xC4, 9, 0, 0}));
    EXPECT_EQ(answer(device, ask(0xE0, {2, 1, 0})), expected_reply(0xE1, {1, 0, 7, 0, 0, 0}));
    answer(device, ask(0xE1, {0, 0, 0x06, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(gain, -0.25f);
    answer(device, ask(0xE1, {1, 0, 200, 0, 0, 0}));
    EXPECT_EQ(small, 9) << "clamped";
    EXPECT_EQ(answer(device, ask(0xE1, Bytes{2, 0, 1, 0, 0, 0})), silence);
}

TEST(Profile, old_counts_commands_in_four_bytes) {
    Device device{{.id = self}, old_at_once()};
    device.commands().add({1, 2, 3}, "GO", "", [] {});
    EXPECT_EQ(answer(device, ask(0xC1, {0, 0, 0})), expected_reply(0xC1, {0, 1, 0, 0, 0}));
}

}    // namespace
}    // namespace profile_tests
