#include <ano_json/nearest.hpp>

#include <gtest/gtest.h>

#include <array>

namespace ano::nearest_tests {
namespace {

constexpr std::string_view keys[] = {"baud", "parity", "stop_bits", "flow", "flood", "peer_timeout", "id"};

TEST(Nearest, finds_slips_of_the_finger) {
    EXPECT_EQ(nearest("bauds", keys), "baud");
    EXPECT_EQ(nearest("buad", keys), "baud");
    EXPECT_EQ(nearest("di", keys), "id") << "two letters swapped are one slip";
    EXPECT_EQ(nearest("stopbits", keys), "stop_bits");
    EXPECT_EQ(nearest("PARITY", keys), "parity");
    EXPECT_EQ(nearest("Bauds", keys), "baud");
    EXPECT_EQ(nearest("flod", keys), "flow");
    EXPECT_EQ(nearest("fload", keys), "flood");
}

TEST(Nearest, of_two_that_differ_in_upper_case_only_takes_the_one_that_is_written_alike) {
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

TEST(Nearest, prefers_the_word_that_was_begun) {
    constexpr std::string_view choices[] = {"auto", "on", "off"};
    EXPECT_EQ(nearest("of", choices), "off");
    EXPECT_EQ(nearest("o", choices), "on");
}

TEST(Nearest, knows_a_number_in_hex_without_its_0x) {
    for (const char* word : {"DC", "dc", "$DC", "#DC", "xDC", "DCh", "\\xDC"})
        EXPECT_EQ(did_you_mean_hex(word), " (did you mean '0xDC'?)") << word;
    EXPECT_EQ(did_you_mean_hex("b"), " (did you mean '0xB'?)");
    EXPECT_EQ(did_you_mean_hex("12h"), " (did you mean '0x12'?)");
    EXPECT_EQ(did_you_mean_hex("7E0", 8), " (did you mean '0x7E0'?)");
    for (const char* word : {"", "h", "x", "12", "300", "7E0", "0xDC", "0xGG", "fc1", "host", "-DC", "DC-DE"})
        EXPECT_EQ(did_you_mean_hex(word), "") << word;
}

TEST(Nearest, suggests_nothing_for_what_is_far) {
    EXPECT_EQ(nearest("encryption", keys), "");
    EXPECT_EQ(nearest("xx", keys), "");
    EXPECT_EQ(nearest("bax", keys), "") << "one slip in so few letters, no two";
    constexpr std::string_view short_ones[] = {"rts", "dtr", "stop_bits"};
    EXPECT_EQ(nearest("bits", short_ones), "stop_bits") << "two of three letters are another word";
    EXPECT_EQ(nearest("", keys), "");
    EXPECT_EQ(nearest(std::string(100'000, 'b'), keys), "");
    EXPECT_EQ(nearest("baud", {}), "");
}

TEST(Nearest, asks_whether_it_was_meant) {
    EXPECT_EQ(did_you_mean("bauds", keys), " (did you mean 'baud'?)");
    EXPECT_EQ(did_you_mean("encryption", keys), "");
}

}    // namespace
}    // namespace ano::nearest_tests
