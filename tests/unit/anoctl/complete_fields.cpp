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

TEST(CompleteFields, offers_messages_first) {
    EXPECT_TRUE(has(offered({"send", ""}), "parameter_command"));
    EXPECT_TRUE(has(offered({"send", "--to", "optical_flow", ""}), "euler")) << "that is an address";
    EXPECT_EQ(offered({}), Words{});
}

TEST(CompleteFields, offers_the_fields_of_the_message_that_are_not_set_yet) {
    EXPECT_EQ(offered({"send", "euler", ""}), (Words{"rol=", "pit=", "yaw=", "fusion_sta=", "mode="}));
    EXPECT_EQ(offered({"send", "euler", "pit=1", "rol", "=", "2", "y"}), (Words{"yaw=", "fusion_sta=", "mode="}));
    EXPECT_EQ(offered({"send", "--to", "optical_flow", "euler", "--from", "imu", ""}).size(), 5u);
}

TEST(CompleteFields, offers_the_names_of_values_after_a_field) {
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd="}), "cmd=action"));
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd=action", "val="}), "val=restore_defaults")) << "no spaces";
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd", "="}), "action")) << "'=' is a word of bash";
    EXPECT_TRUE(has(offered({"send", "parameter_command", "cmd", "=", "a"}), "action"));
    EXPECT_EQ(offered({"send", "euler", "rol="}), Words{});
    EXPECT_EQ(offered({"send", "euler", "nothing="}), Words{});
}

}    // namespace
}    // namespace complete_fields_tests
