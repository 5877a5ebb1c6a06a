#include <gtest/gtest.h>
#include <ano/hex.hpp>
#include <ano_json/text.hpp>

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <support/random.hpp>

namespace text_tests {
namespace {

using namespace ano;
using namespace std::string_literals;

std::string utf8(std::string_view text, Encoding encoding = Encoding::utf8) {
    return to_utf8({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, encoding);
}

TEST(Text, replaces_what_is_not_utf8) {
    const std::string r = "\xEF\xBF\xBD";
    EXPECT_EQ(utf8("plain"), "plain");
    EXPECT_EQ(utf8("β 说 🚁"), "β 说 🚁");
    EXPECT_EQ(utf8("a\xFFz"), "a" + r + "z");
    EXPECT_EQ(utf8("\xC0\x80"), r + r);                    // overlong
    EXPECT_EQ(utf8("\xED\xA0\x80"), r + r + r);            // a surrogate
    EXPECT_EQ(utf8("\xF4\x90\x80\x80"), r + r + r + r);    // above U+10FFFF
    EXPECT_EQ(utf8("\xE8\xAF"), r);                        // cut short
    EXPECT_EQ(utf8("\xE8\xAFz"), r + "z");
}

TEST(Text, of_any_bytes_is_utf8_in_both_encodings) {
    support::Random random{3};
    for (int round = 0; round < 2000; ++round) {
        std::string bytes(random.below(12u), '\0');
        for (char& c : bytes) c = static_cast<char>(random.byte());
        for (const Encoding encoding : {Encoding::utf8, Encoding::gbk, Encoding::automatic})
            ASSERT_TRUE(from_utf8(utf8(bytes, encoding), Encoding::utf8));
    }
}

TEST(Text, gbk_goes_there_and_back) {
    EXPECT_EQ(utf8("\xBD\xE2\xCB\xF8", Encoding::gbk), "解锁");
    EXPECT_EQ(from_utf8("解锁", Encoding::gbk), "\xBD\xE2\xCB\xF8");
    EXPECT_EQ(from_utf8("🚁", Encoding::gbk), std::nullopt);
    EXPECT_EQ(from_utf8("\xFF", Encoding::gbk), std::nullopt);
    EXPECT_EQ(from_utf8("\xFF", Encoding::utf8), std::nullopt);
    const std::string lone_lead = utf8("a\xBD", Encoding::gbk);
    EXPECT_EQ(lone_lead, "a\xEF\xBF\xBD");
    std::string many;
    for (int i = 0; i < 1000; ++i) many += "解锁";
    EXPECT_EQ(utf8(*from_utf8(many, Encoding::gbk), Encoding::gbk), many);
}

TEST(Text, automatic_is_gbk_where_it_is_not_utf8) {
    const auto text = [](std::string_view bytes) { return utf8(bytes, Encoding::automatic); };
    const std::string r = "\xEF\xBF\xBD";
    EXPECT_EQ(text("plain"), "plain");
    EXPECT_EQ(text("说明"), "说明");
    EXPECT_EQ(text("\xBD\xE2\xCB\xF8 ok"), "解锁 ok");
    EXPECT_EQ(text("a\xC0"), "a" + r);          // neither
    EXPECT_EQ(text("说\xE6\x98"), "说" + r);    // cut within a character
    EXPECT_EQ(text("说\xE6"), "说" + r);        // as is this, which could be GBK
    EXPECT_EQ(text("\xFF\xFE"), r + r);
    EXPECT_EQ(from_utf8("解锁", Encoding::automatic), "解锁");
}

TEST(Number, is_read_as_c_writes_it) {
    EXPECT_EQ(parse_number("0xDC"), Number{std::uint64_t{220}});
    EXPECT_EQ(parse_number("-0x10"), Number{std::int64_t{-16}});
    EXPECT_EQ(parse_number("+5"), Number{std::uint64_t{5}});
    EXPECT_EQ(parse_number("-1.5"), Number{-1.5});
    EXPECT_EQ(parse_number("1e-7"), Number{1e-7});
    EXPECT_EQ(parse_number("18446744073709551615"), Number{std::numeric_limits<std::uint64_t>::max()});
    EXPECT_EQ(parse_number("-9223372036854775808"), Number{std::numeric_limits<std::int64_t>::min()});
    EXPECT_EQ(parse_number("010"), Number{std::uint64_t{10}});
    for (const char* wrong : {"", "-", "+", "0x", "1x", "--1", "-+1", "1 ", " 1", "0x1g", "1e", "e5", "0x1FFFFFFFFFFFFFFFF"})
        EXPECT_EQ(parse_number(wrong), std::nullopt) << wrong;
}

TEST(Number, floats_widen_to_what_they_print_as) {
    EXPECT_EQ(widened(0.1f), 0.1);
    EXPECT_EQ(widened(1e-45f), 1e-45);
    support::Random random{5};
    for (int i = 0; i < 100000; ++i) {
        const auto bits = static_cast<std::uint32_t>(random.below(0x7F800000u));
        const float value = std::bit_cast<float>(bits);
        ASSERT_EQ(static_cast<float>(widened(value)), value);
    }
}

TEST(Quotes, keep_a_terminal_from_obeying) {
    EXPECT_EQ(in_quotes("it's"), R"('it\'s')");
    EXPECT_EQ(in_quotes(std::string(200, 'a')), "'" + std::string(200, 'a') + "'");
    EXPECT_EQ(in_quotes(std::string(199, 'a') + "\xC3\xA9" + "bc"), "'" + std::string(199, 'a') + "\xC3\xA9" + "...'");
    EXPECT_EQ(in_quotes("a\xC2\xA0z"), "'a\xC2\xA0z'") << "the first behind the control characters";
    EXPECT_EQ(in_quotes("\x1B[2J\n\x7F\xC2\x9B\xFF", '"'), "\"\\u001b[2J\\u000a\\u007f\\u009b\xEF\xBF\xBD\"");
}

TEST(Hex, is_digits_in_pairs) {
    EXPECT_EQ(hex(std::vector<std::uint8_t>{0xAB, 1}), "ab01");
    EXPECT_EQ(hex_byte(0xDC), "0xDC");
    EXPECT_EQ(hex_byte(5), "0x05");
    EXPECT_EQ(spaced_hex(std::vector<std::uint8_t>{0xAB, 1}), "AB 01");
    EXPECT_EQ(from_hex("aB 01\n"), (std::vector<std::uint8_t>{0xAB, 1}));
    EXPECT_EQ(from_hex(""), std::vector<std::uint8_t>{});
    for (const char* wrong : {"a", "a b", "0x01", "zz", "abc"}) EXPECT_EQ(from_hex(wrong), std::nullopt) << wrong;
}

}    // namespace
}    // namespace text_tests
