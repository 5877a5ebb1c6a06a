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

TEST(StrictJson, faults_have_their_places) {
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
    EXPECT_EQ(faults_of("{} x").size(), 1u);
}

// Where each end of an object looks through all before it, this takes minutes.
TEST(StrictJson, of_many_small_objects_takes_linear_time) {
    std::string text = "[{}";
    for (int i = 0; i < 400'000; ++i) text += ",{}";
    EXPECT_TRUE(faults_of(text + "]").empty());
}

}    // namespace
}    // namespace strict_json_tests
