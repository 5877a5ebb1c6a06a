// The readable form of a link's raw bytes: lines without control characters for a terminal.
#include <anoctl/text/raw_text.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace raw_text_tests {

using namespace anoctl;
using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

namespace {

constexpr ano::TimePoint start{1h};

// Without the time, which depends on the time zone.
Lines without_time(Lines lines) {
    for (std::string& line : lines) line = line.substr(line.find_first_of("<>"));
    return lines;
}

TEST(RawText, shows_complete_lines_of_each_direction_with_any_line_ending) {
    RawText text{{}};
    const auto add = [&](char direction, std::string_view bytes) { return without_time(text.add(direction, 5, bytes, start)); };
    EXPECT_EQ(add('<', "one\r"), Lines{"< one"});
    EXPECT_EQ(add('<', "\ntwo\nthr"), Lines{"< two"});
    EXPECT_EQ(add('>', "AT\r\n"), Lines{"> AT"});
    EXPECT_EQ(add('<', "ee\r\r\n"), (Lines{"< three", "< "}));
    EXPECT_FALSE(text.due());
}

TEST(RawText, shows_a_prompt_after_a_while) {
    RawText text{{}};
    EXPECT_TRUE(text.add('<', 5, "boot> ", start).empty());
    EXPECT_EQ(text.due(), start + RawText::patience);
    EXPECT_TRUE(text.expire(start + RawText::patience - 1ms).empty());
    EXPECT_EQ(without_time(text.expire(start + RawText::patience)), Lines{"< boot> "});
    EXPECT_FALSE(text.due());
}

TEST(RawText, decodes_gbk_even_if_a_character_arrives_in_two_pieces) {
    RawText text{{.encoding = ano::Encoding::gbk}};
    EXPECT_TRUE(text.add('<', 5, "\xB7\xC9\xD0", start).empty());
    EXPECT_EQ(without_time(text.add('<', 5, "\xD0\n", start)), Lines{"< 飞行"});
}

TEST(RawText, breaks_a_very_long_line_into_several_lines) {
    RawText text{{}};
    const Lines lines = text.add('<', 5, std::string(10 * RawText::max_line, 'x'), start);
    EXPECT_EQ(lines.size(), 5u);
}

TEST(RawText, a_device_can_not_control_the_terminal) {
    EXPECT_EQ(harmless("\x1b]0;title\x07 \x7f"), "\\x1B]0;title\\x07 \\x7F");
    EXPECT_EQ(harmless("a\xC2\x9B"
                       "31m"),
              "a\\u{009B}31m")
        << "the C1 control sequence introducer";
    EXPECT_EQ(harmless("\xE2\x80\xAE"
                       "evil\xE2\x81\xA6"),
              "\\u{202E}evil\\u{2066}")
        << "the direction of text";
    EXPECT_EQ(harmless("\xE2\x80\x8B\xEF\xBB\xBF"), "\\u{200B}\\u{FEFF}");
    EXPECT_EQ(harmless("\u034F\u115F\u1160\u3164\uFFA0\u2800"), "\\u{034F}\\u{115F}\\u{1160}\\u{3164}\\u{FFA0}\\u{2800}");
    EXPECT_EQ(harmless("\u17B4\u180B\uFE0F\U0001D173"), "\\u{17B4}\\u{180B}\\u{FE0F}\\u{1D173}");
    EXPECT_EQ(harmless("飞 \xF0\x9F\x98\x80\t|"), "飞 😀    |");
    for (unsigned first = 0; first < 256; ++first)
        for (unsigned second = 0; second < 256; second += 3) {
            RawText text{{.encoding = first % 2 == 0 ? ano::Encoding::gbk : ano::Encoding::utf8}};
            const std::string bytes{static_cast<char>(first), static_cast<char>(second), '\n'};
            for (const std::string& line : text.add('<', 5, bytes, start))
                for (std::size_t i = 0; i < line.size(); ++i) ASSERT_EQ(ano::control_size(line, i), 0u) << first << ' ' << second;
        }
}

TEST(RawText, hex_shows_sixteen_bytes_per_line_and_no_control_characters) {
    RawText text{{.hex = true}};
    const Lines lines = without_time(text.add('>', 5, std::string("ABCDEFGHIJKLMNOP\x1b\x9b", 18), start));
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_EQ(lines[0], "> 41 42 43 44 45 46 47 48 49 4A 4B 4C 4D 4E 4F 50  ABCDEFGHIJKLMNOP");
    EXPECT_TRUE(lines[1].starts_with("> 1B 9B ") && lines[1].ends_with(" ..")) << lines[1];
}

}    // namespace
}    // namespace raw_text_tests
