#include <anoctl/text/prometheus_text.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace anoctl::prometheus_text_tests {
namespace {

std::string as_json(std::string_view text) {
    std::string all;
    for (const ano::Json& sample : samples_of(text)) all += sample.dump() + "\n";
    return all;
}

TEST(PrometheusText, becomes_one_json_object_per_sample) {
    EXPECT_EQ(as_json("# HELP a b\n# TYPE a counter\na_total 7\nb{x=\"1\",y=\"\"} 1.5\n# EOF\n"),
              "{\"name\":\"a_total\",\"labels\":{},\"value\":7}\n"
              "{\"name\":\"b\",\"labels\":{\"x\":\"1\",\"y\":\"\"},\"value\":1.5}\n");
}

TEST(PrometheusText, accepts_labels_with_any_characters) {
    EXPECT_EQ(as_json("a{x=\"}, \\\"1\\\" \\\\ \\n\",y=\"地\"} 1\n"),
              "{\"name\":\"a\",\"labels\":{\"x\":\"}, \\\"1\\\" \\\\ \\n\",\"y\":\"地\"},\"value\":1}\n");
}

TEST(PrometheusText, keeps_numbers_that_json_cannot_represent_as_text) {
    EXPECT_EQ(as_json("a NaN\nb +Inf\nc 18446744073709551615\nd 9007199254740992\n"),
              "{\"name\":\"a\",\"labels\":{},\"value\":\"NaN\"}\n"
              "{\"name\":\"b\",\"labels\":{},\"value\":\"+Inf\"}\n"
              "{\"name\":\"c\",\"labels\":{},\"value\":\"18446744073709551615\"}\n"
              "{\"name\":\"d\",\"labels\":{},\"value\":9007199254740992}\n");
}

TEST(PrometheusText, skips_lines_that_are_not_samples) {
    for (const char* text :
         {"", "\n\n", "a", "a ", "a{", "a{x", "a{x=", "a{x=\"", "a{x=\"1\"", "a{x=\"1\\", "a{x=\"1\"}", "a{}b"})
        EXPECT_EQ(as_json(text), "") << text;
}

}    // namespace
}    // namespace anoctl::prometheus_text_tests
