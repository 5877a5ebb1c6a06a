#include <gtest/gtest.h>
#include <ano/frame.hpp>
#include <ano/hex.hpp>
#include <ano_json/encoding_of_sender.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/shown_text.hpp>
#include <nlohmann/json.hpp>

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

TEST(Text, that_is_not_utf8_is_replaced) {
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

TEST(Text, of_any_bytes_is_converted_to_utf8_from_every_encoding) {
    support::Random random{3};
    for (int round = 0; round < 2000; ++round) {
        std::string bytes(random.below(12u), '\0');
        for (char& c : bytes) c = static_cast<char>(random.byte());
        for (const Encoding encoding : {Encoding::utf8, Encoding::gbk, Encoding::automatic})
            ASSERT_TRUE(from_utf8(utf8(bytes, encoding), Encoding::utf8));
    }
}

TEST(Text, in_gbk_is_converted_to_utf8_and_back) {
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

TEST(Text, of_a_device_loses_only_a_truncated_character) {
    const std::string utf8_text = "横滚P", gbk_text = *from_utf8("横滚P", Encoding::gbk);
    EXPECT_EQ(display_text(utf8_text.substr(0, 5), Encoding::utf8), "横");
    EXPECT_EQ(display_text(utf8_text.substr(0, 4), Encoding::utf8), "横");
    EXPECT_EQ(display_text(utf8_text.substr(0, 1), Encoding::utf8), "");
    EXPECT_EQ(display_text(gbk_text.substr(0, 3), Encoding::gbk), "横");
    EXPECT_EQ(display_text("P" + gbk_text.substr(0, 1), Encoding::gbk), "P");
    for (const Encoding encoding : {Encoding::utf8, Encoding::automatic}) {
        EXPECT_EQ(display_text(utf8_text, encoding), utf8_text);
        EXPECT_EQ(display_text("🚁🚁", encoding), "🚁🚁");
        EXPECT_EQ(display_text(std::string{"🚁🚁"}.substr(0, 7), encoding), "🚁");
    }
    EXPECT_EQ(display_text(gbk_text, Encoding::automatic), "横滚P");
    EXPECT_EQ(display_text(gbk_text.substr(0, 3), Encoding::automatic), "横");
    EXPECT_EQ(display_text("\xAA\xA1" + gbk_text, Encoding::gbk), "\xEF\xBF\xBD横滚P") << "a pair of no character";
    EXPECT_EQ(display_text("\x80z", Encoding::utf8), "\xEF\xBF\xBDz");
}

TEST(Text, of_any_bytes_can_be_shown) {
    support::Random random{4};
    for (int round = 0; round < 2000; ++round) {
        std::string bytes(random.below(12u), '\0');
        for (char& c : bytes) c = static_cast<char>(random.byte());
        for (const Encoding encoding : {Encoding::utf8, Encoding::gbk, Encoding::automatic})
            ASSERT_TRUE(is_utf8(display_text(bytes, encoding)));
        ASSERT_TRUE(may_be_gbk(without_cut_character(*from_utf8("解锁", Encoding::gbk), Encoding::gbk)));
    }
}

TEST(Text, that_controls_or_reorders_a_terminal_is_escaped) {
    const std::pair<const char*, const char*> rows[] = {{"a\u202Eb", "a\\u202eb"},
                                                        {"a\u200Bb", "a\\u200bb"},
                                                        {"\uFEFFx", "\\ufeffx"},
                                                        {"\u2066x\u2069", "\\u2066x\\u2069"},
                                                        {"\u0085", "\\u0085"},
                                                        {"\u061C", "\\u061c"},
                                                        {"\u180E", "\\u180e"},
                                                        {"\U000E0041", "\\udb40\\udc41"},
                                                        {"\x1b[2J", "\\u001b[2J"},
                                                        {"\x7f", "\\u007f"},
                                                        {"横滚P ° é", "横滚P ° é"},
                                                        {"\u2018’…", "\u2018’…"},
                                                        {"a\u034Fb", "a\\u034fb"},
                                                        {"\u115F\u1160", "\\u115f\\u1160"},
                                                        {"\u3164", "\\u3164"},
                                                        {"\uFFA0", "\\uffa0"},
                                                        {"\u2800", "\\u2800"},
                                                        {"ͮᄀᆨ⠁ㅣﾡ", "ͮᄀᆨ⠁ㅣﾡ"},
                                                        {"\u17B4\uFE0F", "\\u17b4\\ufe0f"},
                                                        {"\U000110BD\U0001BCA0", "\\ud804\\udcbd\\ud82f\\udca0"},
                                                        {"\U0001D173\U00013430", "\\ud834\\udd73\\ud80d\\udc30"},
                                                        {"\U000E0FFF\uFFF0", "\\udb43\\udfff\\ufff0"},
                                                        {"\U0001D172\U0001F681\u17B6", "\U0001D172\U0001F681\u17B6"}};
    for (const auto& [text, shown] : rows) {
        EXPECT_EQ(with_escapes(text), shown);
        const std::string json = json_text(nlohmann::ordered_json(text));
        EXPECT_EQ(nlohmann::json::parse(json), text) << json;
        for (const char* hidden :
             {"\u202E", "\u200B", "\uFEFF", "\u2066", "\u0085", "\x1b", "\x7f", "\U000E0041", "\u034F", "\u115F", "\u1160",
              "\u3164", "\uFFA0", "\u2800", "\uFE0F", "\u17B4", "\U000110BD", "\U0001D173"})
            EXPECT_EQ(json.find(hidden), std::string::npos) << json;
    }
    EXPECT_EQ(in_quotes("a\u202Eb"), "'a\\u202eb'");
}

TEST(Text, of_a_sender_is_gbk_from_the_first_text_that_is_not_utf8) {
    EncodingOfSender sender;
    for (const char* text : {"plain", "说明", "说\xE6", "\xC4\xA3", "\xFF\xFE", "a\xE6"}) {
        sender.learn(text);
        EXPECT_EQ(sender.encoding(), Encoding::utf8) << text;
    }
    sender.learn(std::string_view{"\xBD\xE2\xCB"});
    EXPECT_EQ(sender.encoding(), Encoding::gbk);
    sender.learn(std::string_view{"说明"});
    EXPECT_EQ(sender.encoding(), Encoding::gbk);
    EncodingOfSender other;
    const std::vector<std::uint8_t> log{0xAB, 0xDC, 0xFE, 0xA0, 5, 0, 0, 0xBD, 0xE2, 0xCB, 0xF8, 0x8C, 0x2A};
    other.learn(FrameView{log});
    EXPECT_EQ(other.encoding(), Encoding::gbk);
}

TEST(Text, of_a_sender_that_is_valid_in_both_is_gbk_unless_another_text_proves_utf8) {
    const auto encoding_of = [](std::initializer_list<const char*> texts, bool vendor = false) {
        EncodingOfSender sender;
        sender.expect_gbk(vendor);
        for (const char* text : texts) sender.learn(std::string_view{text});
        return sender.encoding();
    };
    EXPECT_EQ(encoding_of({"\xC4\xA3"}), Encoding::gbk) << "模, or ģ";
    EXPECT_EQ(encoding_of({"PID_1", "\xC4\xA3 1"}), Encoding::gbk) << "ASCII letters are in another text";
    EXPECT_EQ(encoding_of({"\xC4\xA3", "说明"}), Encoding::utf8);
    EXPECT_EQ(encoding_of({"说明", "\xC4\xA3"}), Encoding::utf8);
    EXPECT_EQ(encoding_of({"\xC4\xA3",
                           "Gr\xC3\xB6\xC3\x9F"
                           "e"}),
              Encoding::utf8)
        << "ß is no pair of GB 2312";
    EXPECT_EQ(encoding_of({"caf\xC3\xA9"}), Encoding::utf8);
    EXPECT_EQ(encoding_of({"\xC4\xA3"
                           "P"}),
              Encoding::utf8);
    EXPECT_EQ(encoding_of({"\xC4\xA3"
                           "P"},
                          true),
              Encoding::gbk)
        << "profile=vendor";
    EXPECT_EQ(encoding_of({"\xC4\xA3"
                           "P",
                           "说明"},
                          true),
              Encoding::utf8);
    EXPECT_EQ(encoding_of({"25 \xC2\xB0"}), Encoding::utf8) << "a unit";
    EXPECT_EQ(encoding_of({"plain"}, true), Encoding::utf8);
}

TEST(Text, in_automatic_encoding_is_gbk_if_it_is_not_utf8) {
    const auto text = [](std::string_view bytes) { return utf8(bytes, Encoding::automatic); };
    const std::string r = "\xEF\xBF\xBD";
    EXPECT_EQ(text("plain"), "plain");
    EXPECT_EQ(text("说明"), "说明");
    EXPECT_EQ(text("\xBD\xE2\xCB\xF8 ok"), "解锁 ok");
    EXPECT_EQ(text("a\xC0"), "a" + r);          // neither
    EXPECT_EQ(text("说\xE6\x98"), "说" + r);    // truncated within a character
    EXPECT_EQ(text("说\xE6"), "说" + r);        // the same here, which could be GBK
    EXPECT_EQ(text("\xFF\xFE"), r + r);
    EXPECT_EQ(from_utf8("解锁", Encoding::automatic), "解锁");
}

TEST(Number, is_read_in_c_notation) {
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

TEST(Number, floats_widen_to_the_double_that_prints_the_same) {
    EXPECT_EQ(widened(0.1f), 0.1);
    EXPECT_EQ(widened(1e-45f), 1e-45);
    support::Random random{5};
    for (int i = 0; i < 100000; ++i) {
        const auto bits = static_cast<std::uint32_t>(random.below(0x7F800000u));
        const float value = std::bit_cast<float>(bits);
        ASSERT_EQ(static_cast<float>(widened(value)), value);
    }
}

TEST(Quotes, escape_control_characters_for_a_terminal) {
    EXPECT_EQ(in_quotes("it's"), R"('it\'s')");
    EXPECT_EQ(in_quotes(std::string(200, 'a')), "'" + std::string(200, 'a') + "'");
    EXPECT_EQ(in_quotes(std::string(199, 'a') + "\xC3\xA9" + "bc"), "'" + std::string(199, 'a') + "\xC3\xA9" + "...'");
    EXPECT_EQ(in_quotes("a\xC2\xA0z"), "'a\xC2\xA0z'") << "the first behind the control characters";
    EXPECT_EQ(in_quotes("\x1B[2J\n\x7F\xC2\x9B\xFF", '"'), "\"\\u001b[2J\\u000a\\u007f\\u009b\xEF\xBF\xBD\"");
}

TEST(Hex, consists_of_digits_in_pairs) {
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
