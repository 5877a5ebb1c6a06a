#include <gtest/gtest.h>
#include <ano/messages.hpp>
#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include <support/anoctl.hpp>

namespace {

using support::anoctl;

TEST(Messages, the_reference_in_the_repository_is_what_anoctl_prints) {
    std::ifstream file{ANOGATE_SOURCE_DIR "/include/ano/messages.md"};
    const std::string kept{std::istreambuf_iterator<char>{file}, {}};
    EXPECT_EQ(kept, anoctl({"messages", "--markdown"}).out)
        << "build/tools/anoctl messages --markdown > include/ano/messages.md";
}

TEST(Messages, as_json_are_one_object_a_layout) {
    std::istringstream lines{anoctl({"messages", "--json"}).out};
    std::size_t rows = 0;
    for (std::string line; std::getline(lines, line); ++rows) {
        const auto row = nlohmann::json::parse(line);
        const ano::Message& expected = ano::messages[rows];
        EXPECT_EQ(row["id"], expected.id);
        EXPECT_EQ(row["name"], expected.name);
        EXPECT_EQ(row["fields"].size(), expected.fields().size());
    }
    EXPECT_EQ(rows, ano::messages.size());
    const auto euler = nlohmann::json::parse(anoctl({"messages", "--json", "euler"}).out);
    EXPECT_EQ(euler["class"], "telemetry");
    EXPECT_EQ(euler["fields"][0]["scale"], 0.01);
    EXPECT_EQ(euler["fields"][0]["unit"], "°");
}

TEST(Messages, as_text_are_one_line_a_layout) {
    const auto all = anoctl({"messages"}).out;
    EXPECT_EQ(static_cast<std::size_t>(std::count(all.begin(), all.end(), '\n')), ano::messages.size());
    const auto power = anoctl({"messages", "0x0D"}).out;
    EXPECT_EQ(std::count(power.begin(), power.end(), '\n'), 2);
}

TEST(Messages, bad_input_gets_words) {
    EXPECT_EQ(anoctl({"messages", "eulr"}).err, "anoctl: there is no message 'eulr' (did you mean 'euler'?)\n");
    EXPECT_EQ(anoctl({"messages", "eulr"}).exit, 2);
    EXPECT_EQ(anoctl({"messages", "0x77"}).exit, 2);
    EXPECT_EQ(anoctl({"messages", "--json", "--lua"}).exit, 2);
}

TEST(Anoctl, a_command_that_is_none_is_named) {
    const auto ran = anoctl({"mesages"});
    EXPECT_EQ(ran.exit, 2);
    EXPECT_EQ(ran.err, "anoctl: there is no command 'mesages' (did you mean 'messages'?); the commands are decode, encode, messages, monitor\n");
    EXPECT_EQ(anoctl({}).exit, 2);
    EXPECT_EQ(anoctl({}).err, "anoctl: no command; the commands are decode, encode, messages, monitor, and anoctl COMMAND --help says more\n");
}

}    // namespace
