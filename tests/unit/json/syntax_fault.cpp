#include <ano_json/syntax_fault.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ano::syntax_fault_tests {
namespace {

std::string fault_of(std::string_view text) {
    try {
        return "no fault: " + nlohmann::json::parse(text, nullptr, true, true).dump();
    } catch (const nlohmann::json::exception& error) {
        return syntax_fault(text, error);
    }
}

/// The last part, in brackets.
std::string slip_in(std::string_view text) {
    const std::string fault = fault_of(text);
    return fault.ends_with(')') ? fault.substr(fault.rfind(" (") + 2) : std::string{};
}

TEST(SyntaxFault, starts_with_the_line) {
    EXPECT_EQ(fault_of("{\n  \"a\" 1}").rfind("line 2, column 7: syntax error", 0), 0u) << fault_of("{\n  \"a\" 1}");
}

TEST(SyntaxFault, shows_the_number_that_is_too_large) {
    EXPECT_EQ(fault_of("{\n  \"baud\": 1e999}"), "line 2: the number 1e999 is too large");
    EXPECT_EQ(fault_of("-1e999"), "line 1: the number -1e999 is too large");
}

TEST(SyntaxFault, detects_a_missing_comma) {
    for (const char* text :
         {R"({"a": 1 "b": 2})", R"({"a": {} "b": 2})", R"([{"a": 1} {"a": 2}])", "[1 2]", "[[] []]", "[1 true]"})
        EXPECT_EQ(slip_in(text), "is a comma missing before it?)") << fault_of(text);
}

TEST(SyntaxFault, detects_an_extra_comma) {
    for (const char* text : {"[1,]", "{\"a\": 1,\n}", "[1, }"})
        EXPECT_EQ(slip_in(text), "is there an extra comma before it?)") << fault_of(text);
    EXPECT_EQ(slip_in("{\"a\": }"), "");
}

TEST(SyntaxFault, detects_missing_quotes) {
    for (const char* text : {"{a: 1}", "{'a': 1}", "[fc]", "{\"a\": yesterday}"})
        EXPECT_EQ(slip_in(text), "put names and texts in double quotes: \"fc\")") << fault_of(text);
    EXPECT_EQ(slip_in("{\"id\": 0xC7}"), "put hex numbers in double quotes: \"0xDC\")") << fault_of("{\"id\": 0xC7}");
}

TEST(SyntaxFault, detects_an_early_end_and_a_comment_of_another_language) {
    EXPECT_EQ(slip_in("{\"a\": [1"), "is a closing bracket or quote missing?)");
    EXPECT_EQ(slip_in("{} # mine"), "a comment begins with //)") << fault_of("{} # mine");
}

TEST(SyntaxFault, detects_true_and_false_of_other_languages_and_an_empty_file) {
    for (const char* text : {"{\"a\": True}", "{\"a\": FALSE, \"b\": 1}", "[yes]", "{\"a\": no}", "{\"a\": on\n}", "{\"a\": off"})
        EXPECT_EQ(slip_in(text), "write true or false)") << fault_of(text);
    for (const char* text : {"", " \n\n"}) EXPECT_EQ(slip_in(text), "it is empty)") << fault_of(text);
}

TEST(SyntaxFault, accepts_any_text) {
    for (const std::string& text :
         {std::string{}, std::string{"]"}, std::string{"\0\xFF", 2}, std::string{",]"}, std::string{"\"\xFF"}})
        EXPECT_EQ(fault_of(text).rfind("line 1", 0), 0u) << fault_of(text);
}

}    // namespace
}    // namespace ano::syntax_fault_tests
