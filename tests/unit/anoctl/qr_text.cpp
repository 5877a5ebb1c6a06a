#include <gtest/gtest.h>
#include <anoctl/anoctl.hpp>
#include <anoctl/web/qr_text.hpp>

#include <string>
#include <vector>

namespace qr_text_tests {
namespace {

using anoctl::qr_text;

const std::string link = "http://192.168.123.123:8088/#once=0123456789abcdef0123456789abcdef";

/// The modules of the drawing, '1' for a dark one, by rows.
std::vector<std::string> modules(const std::string& text) {
    std::vector<std::string> rows;
    for (std::size_t at = 0; at < text.size();) {
        std::string upper, lower;
        for (; text[at] != '\n';) {
            const bool is_space = text[at] == ' ';
            const std::string cell = text.substr(at, is_space ? 1 : 3);
            upper += cell == "█" || cell == "▀" ? '0' : '1';
            lower += cell == "█" || cell == "▄" ? '0' : '1';
            at += cell.size();
        }
        ++at;
        rows.push_back(upper);
        rows.push_back(lower);
    }
    return rows;
}

TEST(QrText, of_a_link_fits_into_a_terminal_with_its_link_below) {
    const auto rows = modules(qr_text(link, false));
    EXPECT_LE(rows.size() / 2, 20u);
    for (const std::string& row : rows) EXPECT_EQ(row.size(), 37u);
    const auto longest = modules(
        qr_text("http://[2001:db8:1234:5678:9abc:def0:1234:5678]:8088/#once=0123456789abcdef0123456789abcdef", false));
    EXPECT_LE(longest.size() / 2, 21u);
}

TEST(QrText, has_the_three_corners_and_a_margin) {
    const auto rows = modules(qr_text(link, false));
    const std::vector<std::string> corner{"1111111", "1000001", "1011101", "1011101", "1011101", "1000001", "1111111"};
    for (std::size_t i = 0; i < corner.size(); ++i) {
        EXPECT_EQ(rows[2 + i].substr(2, 7), corner[i]);
        EXPECT_EQ(rows[2 + i].substr(28, 7), corner[i]);
        EXPECT_EQ(rows[28 + i].substr(2, 7), corner[i]);
    }
    EXPECT_EQ(rows[0], std::string(37, '0'));
    EXPECT_EQ(rows[36], std::string(37, '0'));
}

TEST(QrText, on_a_terminal_is_black_on_white_whatever_its_colours_are) {
    const std::string drawn = qr_text("x", true);
    EXPECT_EQ(drawn.find("\x1b[38;5;231;48;5;16m"), 0u);
    EXPECT_TRUE(drawn.ends_with("\x1b[0m\n"));
}

TEST(QrText, fails_for_a_text_that_is_too_long) { EXPECT_THROW(qr_text(std::string(3000, 'x'), false), anoctl::Failure); }

}    // namespace
}    // namespace qr_text_tests
