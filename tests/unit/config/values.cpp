#include <ano_json/text.hpp>
#include <config/values.hpp>

#include <gtest/gtest.h>

namespace anogate::values_tests {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

TEST(Values, booleans_are_parsed) {
    for (const char* text : {"yes", "true", "on"}) EXPECT_EQ(parse_boolean(text), true) << text;
    for (const char* text : {"no", "false", "off"}) EXPECT_EQ(parse_boolean(text), false) << text;
    for (const char* text : {"", "1", "TRUE", "yes "}) EXPECT_FALSE(parse_boolean(text)) << text;
}

TEST(Values, numbers_consist_of_decimal_digits_only) {
    EXPECT_EQ(parse_number("0"), 0u);
    EXPECT_EQ(parse_number("18446744073709551615"), UINT64_MAX);
    for (const char* text : {"", "-1", "+1", " 1", "1 ", "1.5", "1e3", "0x10", "18446744073709551616"})
        EXPECT_FALSE(parse_number(text)) << text;
}

TEST(Values, thousandths_are_parsed_with_or_without_a_point) {
    EXPECT_EQ(parse_thousandths("0"), 0u);
    EXPECT_EQ(parse_thousandths("2"), 2000u);
    EXPECT_EQ(parse_thousandths("0.5"), 500u);
    EXPECT_EQ(parse_thousandths("10.25"), 10250u);
    EXPECT_EQ(parse_thousandths("0.125000"), 125u);
    EXPECT_EQ(parse_thousandths("2.0"), 2000u);
    for (const char* wrong : {"", ".", ".5", "1.", "1.2.3", "0.0001", "-1", "1e3", " 1", "99999999999999999999"})
        EXPECT_EQ(parse_thousandths(wrong), std::nullopt) << wrong;
}

TEST(Values, addresses_are_parsed_in_both_notations) {
    EXPECT_EQ(parse_address("220"), 220);
    EXPECT_EQ(parse_address("0xDC"), 220);
    EXPECT_EQ(parse_address("0Xdc"), 220);
    for (const char* text : {"", "256", "0x100", "DC", "0x", "-1", "0xDG"}) EXPECT_FALSE(parse_address(text)) << text;
    EXPECT_EQ(address_text(5), "0x05");
}

TEST(Values, address_ranges_are_parsed) {
    const auto range = parse_addresses("0x1E-40");
    ASSERT_TRUE(range);
    EXPECT_EQ(range->first, 30);
    EXPECT_EQ(range->last, 40);
    EXPECT_EQ(addresses_text(*range), "30-40");
    EXPECT_EQ(addresses_text({220, 220}), "0xDC");
    for (const char* text : {"", "-", "30-", "-40", "40-30", "30-40-50", "30 - 40"}) EXPECT_FALSE(parse_addresses(text)) << text;
}

TEST(Values, durations_are_parsed) {
    EXPECT_EQ(parse_duration("500ms"), milliseconds{500});
    EXPECT_EQ(parse_duration("30s"), seconds{30});
    EXPECT_EQ(parse_duration("2m"), minutes{2});
    EXPECT_EQ(parse_duration("24h"), hours{24});
    EXPECT_EQ(parse_duration("0s"), seconds{0});
    for (const char* text : {"", "s", "30", "-1s", "1.5s", "30 s", "30S", "1d", "18446744073709551615h", "9999999999999ms"})
        EXPECT_FALSE(parse_duration(text)) << text;
}

TEST(Values, durations_are_written_in_the_largest_unit_that_is_exact) {
    EXPECT_EQ(duration_text(milliseconds{1500}), "1500ms");
    EXPECT_EQ(duration_text(seconds{90}), "90s");
    EXPECT_EQ(duration_text(seconds{120}), "2m");
    EXPECT_EQ(duration_text(hours{24}), "24h");
    EXPECT_EQ(duration_text(seconds{0}), "0ms");
}

TEST(Values, sizes_are_parsed_and_written) {
    EXPECT_EQ(parse_size("10MB"), 10'000'000u);
    EXPECT_EQ(parse_size("1KiB"), 1024u);
    EXPECT_EQ(parse_size("123"), 123u);
    EXPECT_EQ(parse_size("0"), 0u);
    for (const char* text : {"", "MB", "10 MB", "10mb", "1.5MB", "-1", "18446744073709551615GB"})
        EXPECT_FALSE(parse_size(text)) << text;
    for (const std::uint64_t size : {0ULL, 1ULL, 999ULL, 1000ULL, 1024ULL, 10'000'000ULL, 1ULL << 30, 3'000'000'001ULL})
        EXPECT_EQ(parse_size(size_text(size)), size) << size_text(size);
    EXPECT_EQ(size_text(10'000'000), "10MB");
}

TEST(Values, invalid_utf8_is_detected) {
    EXPECT_TRUE(ano::is_utf8("飞控 fc \xF0\x9F\x9A\x81"));
    for (const char* text : {"\xFF", "\x80", "\xC3", "\xE9\xA3", "\xC0\xAF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80"})
        EXPECT_FALSE(ano::is_utf8(text)) << testing::PrintToString(text);
}

}    // namespace
}    // namespace anogate::values_tests
