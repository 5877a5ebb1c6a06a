#include <ano_json/strict_json.hpp>

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

namespace strict_json_tests {
namespace {

using ano::JsonFault;

std::vector<JsonFault> faults_of(std::string_view text) {
    std::vector<JsonFault> faults;
    (void)ano::strict_json<nlohmann::json>(text, false, faults);
    return faults;
}

TEST(StrictJson, faults_show_their_location) {
    EXPECT_TRUE(faults_of(R"({"a": [1, {"b": 2}, {"b": 3}], "b": null})").empty());
    const auto twice = faults_of(R"({"a": [1, {"b": 2, "b": 3}]})");
    ASSERT_EQ(twice.size(), 1u);
    EXPECT_EQ(twice[0].pointer, "/a/1/b");
    EXPECT_EQ(twice[0].what, "'b' is given twice");
    const std::string nested = std::string(33, '[') + std::string(33, ']');
    std::vector<JsonFault> none;
    EXPECT_FALSE(ano::strict_json<nlohmann::json>(nested, false, none)) << "what is too deep is not read at all";
    const auto deep = faults_of(nested);
    ASSERT_EQ(deep.size(), 1u);
    EXPECT_EQ(deep[0].what, "nested deeper than 32 levels");
    EXPECT_EQ(deep[0].pointer.rfind("/0/0/0", 0), 0u) << deep[0].pointer;
    EXPECT_EQ(deep[0].pointer.size(), 64u) << deep[0].pointer;
    EXPECT_EQ(faults_of("{} x").size(), 1u);
    const auto second = faults_of(R"({"a": {"b": 1}, "c": [[1], {"d": 1, "e": {"f": [], "f": 2}}]})");
    ASSERT_EQ(second.size(), 1u);
    EXPECT_EQ(second[0].pointer, "/c/1/e/f");
    EXPECT_EQ(faults_of(R"({"a": 1, "a": {"b": [2]}, "a": []})").size(), 2u);
}

template <class Document>
void is_read_as_the_library_does(const std::string& text) {
    std::vector<JsonFault> faults;
    const auto ours = ano::strict_json<Document>(text, true, faults);
    ASSERT_TRUE(ours && faults.empty()) << text;
    EXPECT_EQ(ours->dump(), Document::parse(text, nullptr, true, true).dump());
}

TEST(StrictJson, documents_match_those_of_the_library) {
    for (const char* text :
         {"null", "-5", "18446744073709551615", "1e3", "\"\\u20ac\"", "[]", "{}", "[[], {}, [{}]]", "// a\n[1 /* b */, 2]",
          R"({"z": {"y": [true, {"x": null, "w": {"v": 1.5}}], "u": "t"}, "a": [[1], [2, [3]]], "b": {}})"}) {
        is_read_as_the_library_does<nlohmann::json>(text);
        is_read_as_the_library_does<nlohmann::ordered_json>(text);
    }
    for (const char* text : {"", "[1,]", "{\"a\" 1}", "nul", "\"a", "1e999", "\"\xFF\"", "[1] 2"}) {
        const auto faults = faults_of(text);
        ASSERT_EQ(faults.size(), 1u) << text;
        EXPECT_EQ(faults[0].what.rfind("line 1", 0), 0u) << faults[0].what;
    }
}
// If the end of each object searches all before it, this takes minutes.
TEST(StrictJson, of_many_small_objects_takes_linear_time) {
    std::string text = "[{}";
    for (int i = 0; i < 400'000; ++i) text += ",{}";
    EXPECT_TRUE(faults_of(text + "]").empty());
}

// If each key is compared with all before it, this takes minutes; if the path of each fault is stored, gigabytes.
TEST(StrictJson, of_many_keys_and_many_faults_takes_linear_time) {
    std::string text = "{\"first\": 0";
    for (int i = 0; i < 200'000; ++i) text += ", \"" + std::to_string(i) + "\": 0";
    EXPECT_TRUE(ano::strict_json<nlohmann::ordered_json>(text + "}"));
    text = "{\"" + std::string(100'000, '~') + "\": {\"a\": 0";
    for (int i = 0; i < 100'000; ++i) text += ", \"a\": 0";
    EXPECT_EQ(faults_of(text + "}}").size(), 20u);
    EXPECT_EQ(std::get<std::string>(ano::json_body("[[1], [2, {\"a\": 3}]]", "the message", 5)), "/1/1: more than 5 values");
    EXPECT_TRUE(std::holds_alternative<nlohmann::ordered_json>(ano::json_body("[[1], [2]]", "the message", 5)));
    const auto body = ano::json_body(text + "}}");
    ASSERT_TRUE(std::holds_alternative<std::string>(body));
}

}    // namespace
}    // namespace strict_json_tests
