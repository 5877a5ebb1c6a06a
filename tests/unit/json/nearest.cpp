#include <ano_json/nearest.hpp>

#include <gtest/gtest.h>

#include <array>

namespace ano::nearest_tests {
namespace {

constexpr std::string_view keys[] = {"baud", "parity", "stop_bits", "flow", "flood", "peer_timeout", "id"};

TEST(Nearest, finds_words_with_typing_errors) {
    EXPECT_EQ(nearest("bauds", keys), "baud");
    EXPECT_EQ(nearest("buad", keys), "baud");
    EXPECT_EQ(nearest("di", keys), "id") << "two letters swapped are one slip";
    EXPECT_EQ(nearest("stopbits", keys), "stop_bits");
    EXPECT_EQ(nearest("PARITY", keys), "parity");
    EXPECT_EQ(nearest("Bauds", keys), "baud");
    EXPECT_EQ(nearest("flod", keys), "flow");
    EXPECT_EQ(nearest("fload", keys), "flood");
}

TEST(Nearest, prefers_the_word_in_the_same_case_if_two_differ_only_in_case) {
    constexpr std::array<std::string_view, 2> upper_first{"FLIGHT", "flight"}, lower_first{"flight", "FLIGHT"};
    for (const auto& both : {upper_first, lower_first}) {
        EXPECT_EQ(nearest("fligth", both), "flight");
        EXPECT_EQ(nearest("FLIGTH", both), "FLIGHT");
    }
}

TEST(Nearest, finds_a_part_of_a_word) { EXPECT_EQ(nearest("timeout", keys), "peer_timeout"); }

TEST(Nearest, finds_the_word_that_a_longer_one_begins_with) {
    EXPECT_EQ(nearest("baudrate", keys), "baud");
    EXPECT_EQ(nearest("parity_bits", keys), "parity");
    EXPECT_EQ(nearest("identity", keys), "") << "two letters say nothing";
}

TEST(Nearest, prefers_the_word_that_starts_with_the_input) {
    constexpr std::string_view choices[] = {"auto", "on", "off"};
    EXPECT_EQ(nearest("of", choices), "off");
    EXPECT_EQ(nearest("o", choices), "on");
}

TEST(Nearest, recognizes_a_hex_number_without_0x) {
    for (const char* word : {"DC", "dc", "$DC", "#DC", "xDC", "DCh", "\\xDC"})
        EXPECT_EQ(did_you_mean_hex(word), " (did you mean '0xDC'?)") << word;
    EXPECT_EQ(did_you_mean_hex("b"), " (did you mean '0xB'?)");
    EXPECT_EQ(did_you_mean_hex("12h"), " (did you mean '0x12'?)");
    EXPECT_EQ(did_you_mean_hex("7E0", 8), " (did you mean '0x7E0'?)");
    for (const char* word : {"", "h", "x", "12", "300", "7E0", "0xDC", "0xGG", "fc1", "host", "-DC", "DC-DE"})
        EXPECT_EQ(did_you_mean_hex(word), "") << word;
}

TEST(Nearest, suggests_nothing_for_a_word_that_is_too_different) {
    EXPECT_EQ(nearest("encryption", keys), "");
    EXPECT_EQ(nearest("xx", keys), "");
    EXPECT_EQ(nearest("bax", keys), "") << "one slip in so few letters, no two";
    constexpr std::string_view short_ones[] = {"rts", "dtr", "stop_bits"};
    EXPECT_EQ(nearest("bits", short_ones), "stop_bits") << "two of three letters are another word";
    EXPECT_EQ(nearest("", keys), "");
    EXPECT_EQ(nearest(std::string(100'000, 'b'), keys), "");
    EXPECT_EQ(nearest("baud", {}), "");
}

TEST(Nearest, formats_a_did_you_mean_hint) {
    EXPECT_EQ(did_you_mean("bauds", keys), " (did you mean 'baud'?)");
    EXPECT_EQ(did_you_mean("encryption", keys), "");
}

}    // namespace
}    // namespace ano::nearest_tests
