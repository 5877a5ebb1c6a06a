#include <ano_json/answer_json.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <limits>

namespace anogate::answer_json_tests {
namespace {

using Json = nlohmann::ordered_json;

// A program that reads numbers as doubles would round them.
TEST(AnswerJson, writes_numbers_that_do_not_fit_a_double_as_text) {
    const Json json{{"fits", std::uint64_t{1} << 53},
                    {"beyond", (std::uint64_t{1} << 53) + 1},
                    {"most", std::numeric_limits<std::uint64_t>::max()},
                    {"least", std::numeric_limits<std::int64_t>::min()},
                    {"negative", -(std::int64_t{1} << 53)},
                    {"within", {{{"n", std::uint64_t{1} << 60}}, 1e300, 1.5}}};
    EXPECT_EQ(line_of(json),
              "{\"fits\":9007199254740992,\"beyond\":\"9007199254740993\",\"most\":\"18446744073709551615\","
              "\"least\":\"-9223372036854775808\",\"negative\":-9007199254740992,"
              "\"within\":[{\"n\":\"1152921504606846976\"},1e+300,1.5]}\n");
}

TEST(AnswerJson, replaces_bytes_that_are_not_text) {
    EXPECT_EQ(line_of(Json{{"name", "a\xFF"}}), "{\"name\":\"a\xEF\xBF\xBD\"}\n");
}

}    // namespace
}    // namespace anogate::answer_json_tests
