// Which answers show that a device ignores D_ADDR.
#include <gateway/answer_watch.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace answer_watch_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;

namespace {

constexpr ano::TimePoint start{1h};

struct WatchedAnswers : testing::Test {
    void sent(const Bytes& bytes, ano::TimePoint now = start) { watch.sent(ano::FrameView{bytes}, now); }
    bool is_for_another(const Bytes& bytes, ano::TimePoint now = start) {
        return watch.is_for_another(ano::FrameView{bytes}, now);
    }
    static Bytes acknowledgement(std::uint8_t from, const Bytes& of) {
        const auto checks = ano::FrameView{of}.checks();
        return frame(from, 0xFE, 0x00, {of[3], checks.sum, checks.add});
    }
    AnswerWatch watch;
};

TEST_F(WatchedAnswers, include_an_acknowledgement_of_another_devices_frame) {
    const Bytes command = frame(0xFE, 0x44, 0xC0, {1, 2, 3}), own = frame(0xFE, 0x01, 0xC0, {1, 2, 3});
    EXPECT_FALSE(is_for_another(acknowledgement(0x01, command))) << "nothing was sent";
    sent(command);
    EXPECT_TRUE(is_for_another(acknowledgement(0x01, command)));
    EXPECT_FALSE(is_for_another(acknowledgement(0x44, command)));
    EXPECT_FALSE(is_for_another(acknowledgement(0x01, own))) << "by other check bytes";
    EXPECT_FALSE(is_for_another(acknowledgement(0xFE, command))) << "a host, by an echo";
    EXPECT_TRUE(is_for_another(acknowledgement(0x01, command), start + AnswerWatch::window - 1ms));
    EXPECT_FALSE(is_for_another(acknowledgement(0x01, command), start + AnswerWatch::window));
}

TEST_F(WatchedAnswers, include_an_answer_to_another_devices_request) {
    const Bytes answer = frame(0x01, 0xFE, 0xE1, {5, 0, 9});
    sent(frame(0xFE, 0x44, 0xE0, {2, 5, 0}));
    EXPECT_TRUE(is_for_another(answer));
    EXPECT_FALSE(is_for_another(frame(0x01, 0xFE, 0xE1, {6, 0, 9}))) << "another parameter";
    EXPECT_FALSE(is_for_another(frame(0x01, 0xFE, 0x03, {5, 0, 9})));
    sent(frame(0xFE, 0x01, 0xE0, {2, 5, 0}));
    EXPECT_FALSE(is_for_another(answer)) << "it was asked the same";
}

// Answers with device info don't show which device was asked.
TEST_F(WatchedAnswers, include_a_second_device_info_when_another_device_was_asked_as_well) {
    const Bytes info = frame(0x01, 0xFE, 0xE3, {0x01, 0, 0});
    const auto asked = [&](std::uint8_t to, ano::Duration after) { sent(frame(0xFE, to, 0xE0, {0, 0, 0}), start + after); };
    asked(0x01, 0ms);
    asked(0x01, 1ms);
    asked(0x44, 500ms);
    EXPECT_FALSE(is_for_another(info, start + 600ms));
    EXPECT_FALSE(is_for_another(info, start + 800ms)) << "it was asked twice";
    EXPECT_FALSE(is_for_another(info, start + 899ms)) << "a duplicate";
    EXPECT_TRUE(is_for_another(info, start + 901ms));
    asked(0xFF, 1s);
    EXPECT_FALSE(is_for_another(info, start + 1200ms));
    EXPECT_TRUE(is_for_another(info, start + 1400ms));
}

TEST_F(WatchedAnswers, any_device_may_answer_a_broadcast_or_a_port_request) {
    for (const std::uint8_t to : {std::uint8_t{0xFF}, std::uint8_t{7}}) {
        const Bytes action = frame(0xFE, to, 0xE0, {0x10, 0xAB, 0});
        sent(action);
        EXPECT_FALSE(is_for_another(acknowledgement(0x21, action)));
        sent(frame(0xFE, to, 0xE0, {0, 0, 0}));
        EXPECT_FALSE(is_for_another(frame(0x21, 0xFE, 0xE3, {0x21, 0, 0})));
    }
}

TEST_F(WatchedAnswers, only_the_latest_frames_are_remembered) {
    const Bytes command = frame(0xFE, 0x44, 0xC0, {1, 2, 3});
    sent(command);
    for (std::uint8_t n = 1; n < AnswerWatch::memory; ++n) sent(frame(0xFE, 0x45, 0xC0, {n, 2, 3}));
    sent(frame(0x01, 0xFE, 0xE1, {1, 0, 1}));
    EXPECT_TRUE(is_for_another(acknowledgement(0x01, command))) << "a frame for a host is neither question nor act";
    sent(frame(0xFE, 0x45, 0xC0, {100, 2, 3}));
    EXPECT_FALSE(is_for_another(acknowledgement(0x01, command)));
}

}    // namespace
}    // namespace answer_watch_tests
