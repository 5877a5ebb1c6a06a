#include <anoctl/text/table.hpp>

#include <gtest/gtest.h>

#include <sstream>

namespace anoctl::table_tests {
namespace {

std::string written(const Table& table, std::string_view indent = {}) {
    std::ostringstream out;
    table.write(out, indent);
    return out.str();
}

TEST(Table, a_line_that_is_too_long_is_cut_with_its_colors) {
    EXPECT_EQ(cut_line("0123456789", 10), "0123456789");
    EXPECT_EQ(cut_line("0123456789a", 10), "012345678…");
    EXPECT_EQ(cut_line("0123456789a", 0), "0123456789a");
    EXPECT_EQ(cut_line("\x1b[1m0123456789\x1b[0m", 10), "\x1b[1m0123456789\x1b[0m") << "colours take no cell";
    EXPECT_EQ(cut_line("\x1b[1m0123456789a\x1b[0m", 10), "\x1b[1m012345678…\x1b[0m");
    EXPECT_EQ(cut_line("横滚横滚横滚", 5), "横滚…");
    EXPECT_EQ(cut_line("横滚横滚横滚", 6), "横滚…") << "never more than there is room for";
}

TEST(Table, has_columns_as_wide_as_they_need) {
    Table table{{"LINK", "KIND", "EMPTY", " IN"}};
    table.row({"fc", "serial", "", "7"});
    table.note("  a note that is longer than all of it");
    table.row({"a-long-name", "udp", "", "123456"});
    EXPECT_EQ(written(table),
              "LINK         KIND        IN\n"
              "fc           serial       7\n"
              "  a note that is longer than all of it\n"
              "a-long-name  udp     123456\n");
    EXPECT_EQ(written(table, "  ").find("  LINK"), 0u);
}

TEST(Table, measures_the_display_width_of_characters) {
    EXPECT_EQ(cells_of("abc"), 3u);
    EXPECT_EQ(cells_of("°µ"), 2u);
    EXPECT_EQ(cells_of("飞控1"), 5u);
    EXPECT_EQ(cells_of("\xE9"), 1u) << "cut short";
    Table table{{"NAME", " N"}};
    table.row({"飞控", "1"});
    table.row({"fc", "2"});
    EXPECT_EQ(written(table), "NAME  N\n飞控  1\nfc    2\n");
}

TEST(Table, is_no_wider_than_the_terminal) {
    Table table{{" ID", "NAME", "WHAT"}};
    table.row({"1", "SIM_HEIGHT", "the height at which it hovers"});
    table.row({"12", "B", "short"});
    std::ostringstream wide, narrow, narrower;
    table.write(wide, "", 36);
    EXPECT_EQ(wide.str(),
              "ID  NAME        WHAT\n"
              " 1  SIM_HEIGHT  the height at which\n"
              "                it hovers\n"
              "12  B           short\n");
    table.write(narrow, "", 24);
    EXPECT_EQ(narrow.str(),
              "ID  NAME\n"
              "    WHAT\n"
              " 1  SIM_HEIGHT\n"
              "    the height at which\n"
              "    it hovers\n"
              "12  B\n"
              "    short\n");
    table.write(narrower, "", 1);    // it does not fail, and does not end
    EXPECT_NE(narrower.str().find("hovers"), std::string::npos);
}

TEST(Table, wraps_text_between_words) {
    EXPECT_EQ(wrapped("one two three", 0), "one two three");
    EXPECT_EQ(wrapped("one two three", 8), "one two\nthree");
    EXPECT_EQ(wrapped("one two three", 7, 2), "one two\n  three");
    EXPECT_EQ(wrapped("one two three", 9, 4, 4), "one\n    two\n    three");
    EXPECT_EQ(wrapped("a-word-that-is-too-long to fit", 8), "a-word-that-is-too-long\nto fit");
    EXPECT_EQ(wrapped("  ab cd", 5), "  ab\ncd");
    EXPECT_EQ(wrapped("飞控悬停高度", 6), "飞控悬\n停高度");
    EXPECT_EQ(wrapped("one\ntwo three", 9), "one\ntwo three");
    EXPECT_EQ(wrapped("one two ", 7), "one two ");
    EXPECT_EQ(wrapped("\xE9\x80", 1), "\xE9\x80");
    EXPECT_EQ(in_cells("飞控1", 3), "飞");
    EXPECT_EQ(in_cells("abc", 9), "abc");
}

TEST(Table, shows_no_control_characters) {
    EXPECT_EQ(without_controls("a\x1b[2Jb\n\x7F\xC2\x9B"
                               "c°"),
              "a?[2Jb???c°");
}

TEST(Table, writes_durations_in_readable_units) {
    EXPECT_EQ(time_text(-1), "0.0 s");
    EXPECT_EQ(time_text(0.34), "0.3 s");
    EXPECT_EQ(time_text(9.94), "9.9 s");
    EXPECT_EQ(time_text(9.96), "10 s");
    EXPECT_EQ(time_text(12.4), "12 s");
    EXPECT_EQ(time_text(12.9), "13 s");
    EXPECT_EQ(time_text(119), "119 s");
    EXPECT_EQ(time_text(310), "5 min");
    EXPECT_EQ(time_text(3600 * 3 + 720), "3 h 12 min");
    EXPECT_EQ(time_text(86400), "1 d");
    EXPECT_EQ(time_text(86400 * 2 + 3600 * 3), "2 d 3 h");
}

}    // namespace
}    // namespace anoctl::table_tests
