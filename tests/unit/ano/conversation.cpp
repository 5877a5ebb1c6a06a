// Which frames are questions, answers, actions and writes, and which are acknowledged.
#include <ano/conversation.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

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

TEST(Intent, of_commands_and_writes_is_acts) {
    for (const std::uint8_t id : std::initializer_list<std::uint8_t>{0x40, 0x41, 0x61, 0xC0, 0xE1, 0xF0}) {
        EXPECT_EQ(intent(0xDC, id, {1, 2, 3}), Intent::acts) << int{id};
        EXPECT_EQ(intent(0xFF, id, {1, 2, 3}), Intent::acts) << int{id};
        EXPECT_EQ(intent(0xFE, id, {1, 2, 3}), Intent::informs) << int{id} << ": to a host it is an answer";
        EXPECT_EQ(intent(0xD2, id, {1, 2, 3}), Intent::informs) << int{id};
    }
    EXPECT_EQ(intent(0xDC, 0xE0, {0x10, 0xAA, 0}), Intent::acts);
    EXPECT_EQ(intent(0xDC, 0xE0, {0x55, 0, 0}), Intent::acts) << "not listed";
}

TEST(Intent, of_requests_is_asks) {
    for (std::uint8_t cmd = 0; cmd <= 3; ++cmd) EXPECT_EQ(intent(0xDC, 0xE0, {cmd, 0, 0}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0xC1, {0, 0, 0}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0xC1, {1, 0, 0}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0x60, {0xFF}), Intent::asks);
    EXPECT_EQ(intent(0xDC, 0x60, {3}), Intent::asks);
    EXPECT_EQ(intent(0xFE, 0x60, {3}), Intent::informs);
    EXPECT_EQ(intent(0xFE, 0xE0, {1, 20, 0}), Intent::informs);
    EXPECT_EQ(intent(0xDC, 0xE0, {2, 5}), Intent::informs) << "too short";
    const auto question = [](std::uint8_t to) { return question_in(FrameView{support::frame(0x55, to, 0xE0, {2, 5, 0})}); };
    EXPECT_TRUE(question(0xDC));
    EXPECT_FALSE(question(0xFE));
}

TEST(Intent, of_all_other_frames_is_informs) {
    for (const std::uint8_t id :
         std::initializer_list<std::uint8_t>{0x00, 0x01, 0x03, 0x20, 0xA0, 0xB0, 0xB1, 0xC2, 0xE2, 0xE3, 0xF1})
        EXPECT_EQ(intent(0xDC, id, {1, 2, 3}), Intent::informs) << int{id};
}

TEST(Intent, of_a_request_that_only_hosts_send_identifies_a_host) {
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

using Ids = std::set<unsigned>;

template <class Is>
Ids ids(Is is) {
    Ids all;
    for (unsigned id = 0; id < 256; ++id)
        if (is(static_cast<std::uint8_t>(id))) all.insert(id);
    return all;
}

// As listed in sections 3 and 4 of the protocol text. DATA is long enough for every layout, and its first byte is not listed.
TEST(Conversation, every_id_is_as_in_the_protocol) {
    const Bytes data(32, 0x55);
    const auto is = [&](Intent wanted) { return ids([&](std::uint8_t id) { return intent(0xDC, id, data) == wanted; }); };
    EXPECT_EQ(is(Intent::acts), (Ids{0x40, 0x41, 0x61, 0xC0, 0xE0, 0xE1, 0xF0}));
    EXPECT_EQ(is(Intent::asks), (Ids{0x60})) << "0xC1 and 0xE0 by their first byte";
    EXPECT_EQ(ids([](std::uint8_t id) { return is_for_devices(id); }),
              (Ids{0x40, 0x41, 0x60, 0x61, 0xC0, 0xC1, 0xE0, 0xE1, 0xF0}));
    EXPECT_EQ(ids([&](std::uint8_t id) { return writes(FrameView{support::frame(0xFE, 0xDC, id, data)}); }),
              (Ids{0x61, 0xE1, 0xF0}));
    EXPECT_EQ(ids([&](std::uint8_t id) { return writes(FrameView{support::frame(0xDC, 0xFE, id, data)}); }), Ids{});
    EXPECT_EQ(ids([&](std::uint8_t id) { return ano::is_control(FrameView{support::frame(0xFE, 0xDC, id, data)}); }),
              is(Intent::acts));
    EXPECT_EQ(ids([](std::uint8_t id) { return may_be_acknowledged(id); }), (Ids{0x61, 0xC0, 0xE0, 0xE1}));
    EXPECT_EQ(ids([](std::uint8_t id) { return may_answer(id); }),
              (Ids{0x00, 0x60, 0x61, 0xC1, 0xC2, 0xE0, 0xE1, 0xE2, 0xE3, 0xF0}));
}

// For each first byte of DATA, the id of the answer; none if there is no answer.
TEST(Conversation, every_first_byte_is_answered_as_in_the_protocol) {
    const auto answered = [](std::uint8_t id) {
        std::map<int, Ids> by_answer;    // first bytes by the id of the answer
        for (unsigned first = 0; first < 256; ++first) {
            Bytes data(22);
            data[0] = static_cast<std::uint8_t>(first);
            const auto answer = answer_to(FrameView{support::frame(0xFE, 0xDC, id, data)});
            by_answer[answer ? answer->id() : -1].insert(first);
        }
        return by_answer;
    };
    const auto all_but = [](const Ids& but) { return ids([&](std::uint8_t id) { return !but.contains(id); }); };
    using Answered = std::map<int, Ids>;
    for (unsigned id = 0; id < 256; ++id) {
        Answered expected{{-1, all_but({})}};
        if (id == 0x60) expected = {{0x60, {0xFF}}, {0x61, all_but({0xFF})}};
        if (id == 0xC1) expected = {{0xC1, {0}}, {0xC2, {1}}, {-1, all_but({0, 1})}};
        if (id == 0xE0)
            expected = {{0xE3, {0}}, {0xE0, {1}}, {0xE1, {2}}, {0xE2, {3}}, {0x00, {0x10}}, {-1, all_but({0, 1, 2, 3, 0x10})}};
        if (id == 0x61 || id == 0xC0 || id == 0xE1) expected = {{0x00, all_but({})}};
        if (id == 0xF0) expected = {{0xF0, all_but({})}};
        EXPECT_EQ(answered(static_cast<std::uint8_t>(id)), expected) << id;
    }
}

bool is_answered(std::uint8_t id, const Bytes& data, std::uint8_t answer, const Bytes& by) {
    const auto expected = answer_to(FrameView{support::frame(0xFE, 0xDC, id, data)});
    return expected && answer_in(FrameView{support::frame(0xDC, 0xFE, answer, by)}) == *expected;
}

TEST(Answer, repeats_the_number_of_the_request) {
    EXPECT_TRUE(is_answered(0xE0, {2, 0x34, 0x12}, 0xE1, {0x34, 0x12, 7}));
    EXPECT_FALSE(is_answered(0xE0, {2, 0x34, 0x12}, 0xE1, {0x34, 0x13, 7}));
    EXPECT_FALSE(is_answered(0xE0, {2, 0x34, 0x12}, 0xE2, {0x34, 0x12, 7}));
    EXPECT_FALSE(is_answered(0xE0, {2, 0x34, 0x12}, 0xE1, {0x34}));
    EXPECT_TRUE(is_answered(0xC1, {1, 5, 0}, 0xC2, {5, 0, 1}));
    EXPECT_FALSE(is_answered(0xC1, {1, 5, 0}, 0xC2, {6, 0, 1}));
    EXPECT_TRUE(is_answered(0x60, {3}, 0x61, {3, 1}));
    EXPECT_FALSE(is_answered(0x60, {3}, 0x61, {4, 1}));
    EXPECT_TRUE(is_answered(0x60, {0xFF}, 0x60, {9}));
    EXPECT_TRUE(is_answered(0xC1, {0, 0, 0}, 0xC1, {0, 9, 0, 0, 0})) << "older devices send two more zero bytes";
    EXPECT_FALSE(is_answered(0xC1, {0, 0, 0}, 0xC1, {1, 9, 0}));
    EXPECT_TRUE(is_answered(0xE0, {1, 0, 0}, 0xE0, {1, 20, 0}));
    EXPECT_FALSE(is_answered(0xE0, {1, 0, 0}, 0xE0, {2, 20, 0}));
    EXPECT_TRUE(is_answered(0xE0, {0, 0, 0}, 0xE3, {0xDC}));
}

TEST(Answer, to_a_write_repeats_its_id_and_both_checks) {
    const Bytes written = support::frame(0xFE, 0xDC, 0xE1, {5, 0, 1});
    const Checks checks = FrameView{written}.checks();
    const auto acknowledges = [&](const Bytes& data) {
        return answer_in(FrameView{support::frame(0xDC, 0xFE, 0x00, data)}) == answer_to(FrameView{written});
    };
    EXPECT_TRUE(acknowledges({0xE1, checks.sum, checks.add}));
    EXPECT_FALSE(acknowledges({0xC0, checks.sum, checks.add}));
    EXPECT_FALSE(acknowledges({0xE1, static_cast<std::uint8_t>(checks.sum + 1), checks.add}));
    EXPECT_FALSE(acknowledges({0xE1, checks.sum, static_cast<std::uint8_t>(checks.add + 1)}));
    EXPECT_FALSE(acknowledges({0xE1, checks.sum}));
}

TEST(Answer, is_not_expected_to_a_request_that_is_too_short) {
    EXPECT_FALSE(answer_to(FrameView{support::frame(0xFE, 0xDC, 0xE0, {0})}));
    EXPECT_FALSE(answer_to(FrameView{support::frame(0xFE, 0xDC, 0x60, {})}));
}

// An action that can't be distinguished from a question would pass an inhibit switch.
TEST(Control, includes_unlisted_actions_and_actions_without_data) {
    const auto is_control = [](const Bytes& data) { return ano::is_control(FrameView{support::frame(0xFE, 0xDC, 0xE0, data)}); };
    EXPECT_TRUE(is_control({}));
    EXPECT_FALSE(is_control({0, 0, 0})) << "the question for the device info";
    EXPECT_TRUE(is_control({0x77, 0, 0})) << "not listed";
}

TEST(Id, of_a_name_is_known_when_the_program_is_compiled) {
    static_assert(ano::id_of<"command"> == 0xC0);
    static_assert(ano::id_of<"firmware"> == 0xF0);
    for (const ano::Message& row : ano::messages) EXPECT_EQ(ano::find_message(row.name)->id, row.id);
}

}    // namespace
}    // namespace conversation_tests
