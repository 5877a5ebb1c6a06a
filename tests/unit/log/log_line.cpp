#include <log/log_line.hpp>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <support/log_lines.hpp>

#include <string>

namespace anogate::log_line_tests {
namespace {

using Lines = std::vector<std::string>;

// Its text is made when it is formatted, which may fail.
struct Counted {
    int* formatted;
    bool fails = false;
};

}    // namespace
}    // namespace anogate::log_line_tests

template <>
struct fmt::formatter<anogate::log_line_tests::Counted> {
    constexpr auto parse(format_parse_context& context) { return context.begin(); }
    template <class Context>
    auto format(const anogate::log_line_tests::Counted& counted, Context& context) const {
        ++*counted.formatted;
        if (counted.fails) throw std::bad_alloc{};
        return fmt::format_to(context.out(), "counted");
    }
};

namespace anogate::log_line_tests {
namespace {

TEST(LogLine, is_in_the_log_with_its_level) {
    support::LogLines lines;
    spdlog::default_logger()->set_pattern("%l %v");
    log_info("{}: peer {}", "ground", 7);
    log_warning("{:.1f} s", 1.25);
    log_error("{} {{}}", "as it is: {}");
    EXPECT_EQ(lines.pop_all(), (Lines{"info ground: peer 7", "warning 1.2 s", "error as it is: {} {}"}));
}

TEST(LogLine, replaces_invalid_utf8_and_escapes_invisible_characters) {
    support::LogLines lines;
    log_warning("a {} file", std::string{"\xFB\x84\x1B[2J\u202E\uFE0F\xC2"});
    EXPECT_EQ(lines.pop_all(), (Lines{"a \uFFFD\uFFFD\\u001b[2J\\u202e\\ufe0f\uFFFD file"}));
}

TEST(LogLine, below_the_level_is_neither_logged_nor_formatted) {
    support::LogLines lines;
    int formatted = 0;
    set_log_level("warn");
    log_info("{}", Counted{&formatted});
    EXPECT_EQ(formatted, 0);
    log_warning("{}", Counted{&formatted});
    EXPECT_EQ(formatted, 1);
    EXPECT_EQ(lines.pop_all(), Lines{"counted"});
}

TEST(LogLine, that_was_requested_is_logged_at_every_level_except_off) {
    support::LogLines lines;
    spdlog::default_logger()->set_pattern("%l %v");
    set_log_level("error");
    log_asked("status {}");
    EXPECT_EQ(lines.pop_all(), Lines{"info status {}"});
    set_log_level("off");
    log_asked("status");
    EXPECT_TRUE(lines.pop_all().empty());
}

TEST(LogLine, that_cannot_be_formatted_is_lost_without_stopping_the_log) {
    support::LogLines lines;
    int formatted = 0, lost = 0;
    spdlog::default_logger()->set_error_handler([&](const std::string&) { ++lost; });
    log_error("{}", Counted{&formatted, true});
    log_error("the next");
    EXPECT_EQ(lost, 1);
    EXPECT_EQ(lines.pop_all(), Lines{"the next"});
}

}    // namespace
}    // namespace anogate::log_line_tests
