#include <anoctl/device/refused_lengths.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace refused_lengths_tests {
namespace {

using anoctl::refused_lengths;

TEST(RefusedLengths, names_the_link_and_the_setting_to_change) {
    const ano::Json before = ano::Json::parse(
        R"({"links": [{"name": "cam", "bad_length": 3, "too_big": 1}, {"name": "ground", "too_big": 0}]})");
    EXPECT_TRUE(refused_lengths(before, before).empty());
    const ano::Json now = ano::Json::parse(
        R"({"links": [{"name": "cam", "bad_length": 5, "too_big": 1}, {"name": "ground", "too_big": 4}]})");
    const auto sentences = refused_lengths(before, now);
    ASSERT_EQ(sentences.size(), 2u);
    EXPECT_EQ(sentences[0],
              "the link 'cam' refused 2 headers due to LEN (bad_length); if pictures are missing, set max_data on it "
              "to their LEN, at most 65535");
    EXPECT_EQ(sentences[1],
              "4 frames did not fit the link 'ground' (too_big); set max_data_out on it to their LEN, at most 65535, "
              "and queue to twice that");
    const ano::Json with_image = ano::Json::parse(R"({"links": [{"name": "cam", "bad_length": 5, "longest_image": 22417}]})");
    EXPECT_EQ(refused_lengths(before, with_image).at(0),
              "the link 'cam' refused 2 headers due to LEN (bad_length); if pictures are missing, set max_data=22417 on it");
    EXPECT_TRUE(refused_lengths({}, {}).empty()) << "no gateway answers";
    EXPECT_TRUE(refused_lengths(now, before).empty()) << "it was started again";
}

}    // namespace
}    // namespace refused_lengths_tests
