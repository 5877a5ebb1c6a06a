#include <anoctl/table.hpp>

#include <gtest/gtest.h>

#include <sstream>

namespace anoctl {
namespace {

std::string written(const Table& table, std::string_view indent = {}) {
    std::ostringstream out;
    table.write(out, indent);
    return out.str();
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

TEST(Table, knows_how_wide_characters_are) {
    EXPECT_EQ(cells_of("abc"), 3u);
    EXPECT_EQ(cells_of("°µ"), 2u);
    EXPECT_EQ(cells_of("飞控1"), 5u);
    EXPECT_EQ(cells_of("\xE9"), 1u) << "cut short";
    Table table{{"NAME", " N"}};
    table.row({"飞控", "1"});
    table.row({"fc", "2"});
    EXPECT_EQ(written(table), "NAME  N\n飞控  1\nfc    2\n");
}

TEST(Table, shows_no_control_characters) {
    EXPECT_EQ(without_controls("a\x1b[2Jb\n\x7F\xC2\x9B"
                               "c°"),
              "a?[2Jb???c°");
}

TEST(Table, writes_times_as_people_say_them) {
    EXPECT_EQ(time_text(-1), "0.0 s");
    EXPECT_EQ(time_text(0.34), "0.3 s");
    EXPECT_EQ(time_text(12.9), "12 s");
    EXPECT_EQ(time_text(119), "119 s");
    EXPECT_EQ(time_text(310), "5 min");
    EXPECT_EQ(time_text(3600 * 3 + 720), "3 h 12 min");
    EXPECT_EQ(time_text(86400), "1 d");
    EXPECT_EQ(time_text(86400 * 2 + 3600 * 3), "2 d 3 h");
}

}    // namespace
}    // namespace anoctl
