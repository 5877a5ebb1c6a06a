// Which frames ask, answer and act.
#include <ano/conversation.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace conversation_tests {

using namespace ano;
using support::Bytes;

namespace {

Intent intent(std::uint8_t to, std::uint8_t id, const Bytes& data = {}) {
    const Bytes bytes = support::frame(0xFE, to, id, data);
    return intent_of(FrameView{bytes});
}
bool is_of_a_host(std::uint8_t id, const Bytes& data) {
    const Bytes bytes = support::frame(0x55, 0xDC, id, data);
    return ano::is_of_a_host(FrameView{bytes});
}

TEST(Intent, of_what_commands_or_writes) {
    for (const std::uint8_t id : std::initializer_list<std::uint8_t>{0x40, 0x41, 0x61, 0xC0, 0xE1, 0xF0}) {
        EXPECT_EQ(intent(0xDC, id, {1, 2, 3}), Intent::acts) << int{id};
        EXPECT_EQ(intent(0xFF, id, {1, 2, 3}), Intent::acts) << int{id};
        EXPECT_EQ(intent(0xFE, id, {1, 2, 3}), Intent::informs) << int{id} << ": to a host it is an answer";
        EXPECT_EQ(intent(0xD2, id, {1, 2, 3}), Intent::informs) << int{id};
    }
    EXPECT_EQ(intent(0xDC, 0xE0, {0x10, 0xAA, 0}), Intent::acts);
    EXPECT_EQ(intent(0xDC, 0xE0, {0x55, 0, 0}), Intent::acts) << "not listed";
}

TEST(Intent, of_questions) {
    for (std::uint8_t cmd = 0; cmd <= 3; ++cmd) EXPECT_EQ(intent(0xDC, 0xE0, {cmd, 0, 0}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0xC1, {0, 0, 0}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0xC1, {1, 0, 0}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0x60, {0xFF}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0x60, {3}), Intent::asks);
    EXPECT_EQ(intent(0xFE, 0x60, {3}), Intent::informs);
    EXPECT_EQ(intent(0xFE, 0xE0, {1, 20, 0}), Intent::informs);
}

TEST(Intent, of_the_rest) {
    for (const std::uint8_t id :
         std::initializer_list<std::uint8_t>{0x00, 0x01, 0x03, 0x20, 0xA0, 0xB0, 0xB1, 0xC2, 0xE2, 0xE3, 0xF1})
        EXPECT_EQ(intent(0xDC, id, {1, 2, 3}), Intent::informs) << int{id};
}

TEST(Intent, of_a_question_that_no_device_can_have_sent_shows_a_host) {
    EXPECT_TRUE(is_of_a_host(0xE0, {0, 0, 0}));
    EXPECT_TRUE(is_of_a_host(0xE0, {2, 5, 0}));
    EXPECT_TRUE(is_of_a_host(0xE0, {3, 5, 0}));
    EXPECT_TRUE(is_of_a_host(0xC1, {1, 5, 0}));
    EXPECT_FALSE(is_of_a_host(0xE0, {1, 5, 0})) << "a device says so how many parameters it has";
    EXPECT_FALSE(is_of_a_host(0xC1, {0, 5, 0}));
    EXPECT_FALSE(is_of_a_host(0x60, {5}));
    EXPECT_FALSE(is_of_a_host(0xE1, {5, 0, 1})) << "an answer, or a write";
    EXPECT_FALSE(is_of_a_host(0xC0, {1, 2, 3})) << "small boards command flight controllers";
    EXPECT_FALSE(is_of_a_host(0xE0, {0x10, 0xAA, 0}));
    EXPECT_FALSE(is_of_a_host(0xE0, {0}));
}

}    // namespace
}    // namespace conversation_tests
