#include <log/log.hpp>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <support/temp_dir.hpp>

#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

namespace anogate::log_tests {
namespace {

TEST(JournalLines, have_their_priority) {
    EXPECT_EQ(journal_lines(Priority::warning, "fc: gone"), "<4>fc: gone\n");
    EXPECT_EQ(journal_lines(Priority::error, "bad"), "<3>bad\n");
    EXPECT_EQ(journal_lines(Priority::info, "up"), "<6>up\n");
    EXPECT_EQ(journal_lines(Priority::debug, "x"), "<7>x\n");
    EXPECT_EQ(journal_lines(Priority::info, ""), "");
}

TEST(JournalLines, have_a_priority_on_every_line_whatever_it_begins_with) {
    EXPECT_EQ(journal_lines(Priority::info, "status\nfc: up\n<0>panic\n"), "<6>status\n<6>fc: up\n<6><0>panic\n");
    EXPECT_EQ(journal_lines(Priority::info, "\n\na\n\n"), "<6>a\n");
}

// The output of a log on a terminal for one warning.
std::string on_a_terminal(const char* no_color) {
    int ours = -1, terminal = -1;
    if (::openpty(&ours, &terminal, nullptr, nullptr, nullptr) != 0) return "no pty";
    ::setenv("TERM", "xterm", 1);
    ::setenv("NO_COLOR", no_color, 1);
    ::unsetenv("JOURNAL_STREAM");
    const int before = ::dup(STDERR_FILENO);
    ::dup2(terminal, STDERR_FILENO);
    start_log({});
    spdlog::warn("words");
    pollfd written{ours, POLLIN, 0};    // by another thread, in pieces
    std::string text;
    while (!text.ends_with('\n') && ::poll(&written, 1, 10'000) == 1) {
        char piece[256];
        const ssize_t n = ::read(ours, piece, sizeof piece);
        text.append(piece, n > 0 ? static_cast<std::size_t>(n) : 0);
    }
    end_log();
    ::dup2(before, STDERR_FILENO);
    for (const int fd : {ours, terminal, before}) ::close(fd);
    return text;
}

TEST(Log, has_colours_on_a_terminal_unless_no_color_is_set) {
    EXPECT_NE(on_a_terminal("").find('\x1b'), std::string::npos);
    const std::string plain = on_a_terminal("1");
    EXPECT_NE(plain.find("warning words"), std::string::npos) << plain;
    EXPECT_EQ(plain.find('\x1b'), std::string::npos) << plain;
}

TEST(Log, supports_a_rotation_size_of_more_than_32_bits) {
    const support::TempDir folder;
    LogSettings settings;
    settings.file = folder / "log";
    settings.rotate = std::uint64_t{1} << 32;
    start_log(settings);
    spdlog::warn("words");
    end_log();
    std::ifstream file{settings.file};
    const std::string text{std::istreambuf_iterator<char>{file}, {}};
    EXPECT_NE(text.find("words"), std::string::npos) << text;
}

}    // namespace
}    // namespace anogate::log_tests
