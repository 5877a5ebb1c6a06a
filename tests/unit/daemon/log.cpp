#include <daemon/log.hpp>

#include <gtest/gtest.h>

namespace anogate {
namespace {

TEST(JournalLines, have_their_priority) {
    EXPECT_EQ(journal_lines(Priority::warning, "fc: gone"), "<4>fc: gone\n");
    EXPECT_EQ(journal_lines(Priority::error, "bad"), "<3>bad\n");
    EXPECT_EQ(journal_lines(Priority::info, "up"), "<6>up\n");
    EXPECT_EQ(journal_lines(Priority::debug, "x"), "<7>x\n");
    EXPECT_EQ(journal_lines(Priority::info, ""), "");
}

TEST(JournalLines, every_line_has_it_whatever_it_begins_with) {
    EXPECT_EQ(journal_lines(Priority::info, "status\nfc: up\n<0>panic\n"), "<6>status\n<6>fc: up\n<6><0>panic\n");
    EXPECT_EQ(journal_lines(Priority::info, "\n\na\n\n"), "<6>a\n");
}

}  // namespace
}  // namespace anogate
