#include <ano/control.hpp>
#include <ano/messages.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <set>

namespace control_tests {

TEST(Acknowledged, what_is_written_or_done_may_be) {
    std::set<int> ids;
    for (int id = 0; id < 256; ++id)
        if (ano::may_be_acknowledged(static_cast<std::uint8_t>(id))) ids.insert(id);
    EXPECT_EQ(ids, (std::set<int>{0x61, 0xC0, 0xE0, 0xE1}));
}

// An action that can't be told from a question would pass an inhibit switch.
TEST(Control, is_every_message_that_is_acknowledged) {
    for (const ano::Message& row : ano::messages) {
        if (row.acknowledged == ano::Acknowledged::no) continue;
        EXPECT_NE(row.controls, ano::Controls::no) << row.name;
    }
}

TEST(Control, is_what_may_be_a_question_and_says_nothing) {
    const auto is_control = [](const support::Bytes& data) {
        return ano::is_control(ano::FrameView{support::frame(0xFE, 0xDC, 0xE0, data)});
    };
    EXPECT_TRUE(is_control({}));
    EXPECT_FALSE(is_control({0, 0, 0})) << "the question for the device info";
    EXPECT_TRUE(is_control({0x77, 0, 0})) << "not listed";
}

TEST(Id, of_a_name_is_known_when_the_program_is_compiled) {
    static_assert(ano::id_of<"command"> == 0xC0);
    static_assert(ano::id_of<"firmware"> == 0xF0);
    for (const ano::Message& row : ano::messages) EXPECT_EQ(ano::find_message(row.name)->id, row.id);
}

}    // namespace control_tests
