#include <anoctl/complete_fields.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace complete_fields_tests {
namespace {

using Words = std::vector<std::string>;

Words offered(const std::vector<const char*>& words) { return anoctl::field_words(words); }
bool has(const Words& words, const std::string& word) { return std::find(words.begin(), words.end(), word) != words.end(); }

TEST(CompleteFields, a_message_comes_first) {
    EXPECT_TRUE(has(offered({"send", ""}), "parameter_command"));
    EXPECT_TRUE(has(offered({"send", "--to", "optical_flow", ""}), "euler")) << "that is an address";
    EXPECT_EQ(offered({}), Words{});
}

TEST(CompleteFields, then_the_fields_that_it_has_and_were_not_given) {
    EXPECT_EQ(offered({"send", "euler", ""}), (Words{"rol=", "pit=", "yaw=", "fusion_sta=", "mode="}));
    EXPECT_EQ(offered({"send", "euler", "pit=1", "rol", "=", "2", "y"}), (Words{"yaw=", "fusion_sta=", "mode="}));
    EXPECT_EQ(offered({"send", "--to", "optical_flow", "euler", "--from", "imu", ""}).size(), 5u);
}

TEST(CompleteFields, behind_a_field_the_words_for_its_values) {
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd="}), "cmd=action"));
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd=action", "val="}), "val=restore_defaults")) << "no spaces";
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd", "="}), "action")) << "'=' is a word of bash";
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd", "=", "a"}), "action"));
    EXPECT_EQ(offered({"send", "euler", "rol="}), Words{});
    EXPECT_EQ(offered({"send", "euler", "nothing="}), Words{});
}

}    // namespace
}    // namespace complete_fields_tests
