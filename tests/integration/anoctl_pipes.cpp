// anoctl between two pipes: input is forwarded at once, and it ends when its output has no reader.
#include <support/bytes.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <vector>

namespace anoctl_pipes_tests {
namespace {

using namespace support;

// anoctl with a pipe as its input that stays open.
class Piped {
public:
    explicit Piped(const std::string& command)
        : path_{made(dir_ / "input")}, anoctl_{"/bin/sh", {"-c", "exec \"$0\" " + command + " < " + path_, ANOCTL}} {
        wait_until([this] { return (input_ = ::open(path_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC)) >= 0; });
        std::signal(SIGPIPE, SIG_IGN);    // it may end before everything is written
    }
    ~Piped() { ::close(input_); }
    Piped(const Piped&) = delete;
    Piped& operator=(const Piped&) = delete;

    bool write(const std::string& bytes) const {
        return ::write(input_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
    }
    Process& anoctl() { return anoctl_; }

private:
    static std::string made(const std::string& path) { return ::mkfifo(path.c_str(), 0600) == 0 ? path : ""; }

    TempDir dir_;
    std::string path_;
    Process anoctl_;
    int input_ = -1;
};

const std::string json = R"({"name": "euler", "fields": {"rol": 1.5}})"
                         "\n";
const std::string encoded = "AB FE FF 03 07 00 96 00 00 00 00 00 00 48 03\n";

std::string frame_bytes() {
    const Bytes bytes = frame(0xDC, 0xFE, 0x03, {1, 2, 3, 4, 5, 6, 0});
    return {bytes.begin(), bytes.end()};
}

TEST(AnoctlPipes, a_frame_is_shown_as_soon_as_it_is_received) {
    Piped piped{"decode -"};
    ASSERT_TRUE(piped.write(frame_bytes()));
    EXPECT_TRUE(piped.anoctl().until_says("euler"));
    EXPECT_TRUE(piped.anoctl().is_running());
}

// Opening it would wait for a writer. A pipe of the shell, <(command), has one.
TEST(AnoctlPipes, a_named_pipe_is_not_opened_as_a_file) {
    const TempDir dir;
    const std::string pipe = dir / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    for (const std::vector<std::string>& words : {std::vector<std::string>{"decode", pipe},
                                                  {"info", pipe},
                                                  {"convert", pipe, dir / "out.csv"},
                                                  {"flash", pipe, "--yes"}}) {
        Process anoctl{ANOCTL, words};
        ASSERT_TRUE(wait_until([&] { return !anoctl.is_running(); })) << words[0] << " waits";
        EXPECT_EQ(anoctl.wait(), 2) << words[0];
        EXPECT_NE(anoctl.output().find(pipe + ": is not a regular file"), std::string::npos) << words[0] << anoctl.output();
    }
    Process of_shell{"/bin/bash", {"-c", "exec \"$0\" decode <(printf '\\xAB')", ANOCTL}};
    EXPECT_EQ(of_shell.wait(), 1);
    EXPECT_EQ(of_shell.output().find("regular file"), std::string::npos) << of_shell.output();
}

TEST(AnoctlPipes, a_line_is_encoded_as_soon_as_it_is_received) {
    Piped piped{"encode -"};
    for (const std::string& piece : {json.substr(0, 9), json.substr(9) + json + json.substr(0, 20)})
        ASSERT_TRUE(piped.write(piece));
    EXPECT_TRUE(piped.anoctl().until_says(encoded + encoded)) << piped.anoctl().output();
    EXPECT_TRUE(piped.anoctl().is_running());
}

TEST(AnoctlPipes, a_line_without_end_is_refused) {
    Piped piped{"encode -"};
    const std::string piece(4096, ' ');
    EXPECT_TRUE(wait_until([&] { return !piped.write(piece) && !piped.anoctl().is_running(); }));
    EXPECT_EQ(piped.anoctl().wait(), 2);
    EXPECT_EQ(piped.anoctl().output(), "anoctl: line 1: longer than 1 MiB\n");
}

TEST(AnoctlPipes, it_ends_when_its_output_cannot_be_written) {
    for (const auto& [command, input] : {std::pair{"decode -", frame_bytes()}, {"encode -", json}}) {
        Piped piped{std::string{command} + " > /dev/full"};
        ASSERT_TRUE(piped.write(input));
        EXPECT_EQ(piped.anoctl().wait(), 1) << command;
        EXPECT_EQ(piped.anoctl().output(), "anoctl: cannot write the output\n");
    }
    for (const char* option : {"--help", "param --help", "--version", "messages"}) {
        Piped piped{std::string{option} + " > /dev/full"};
        EXPECT_EQ(piped.anoctl().wait(), 1) << option;
        EXPECT_EQ(piped.anoctl().output(), "anoctl: cannot write the output\n") << option;
    }
}

// The output of anoctl on a terminal. `no_color` is the value of NO_COLOR; null: it is not set.
std::string on_a_terminal(const char* no_color) {
    int terminal = -1;
    const pid_t pid = forkpty(&terminal, nullptr, nullptr, nullptr);
    if (pid == 0) {
        ::setenv("TERM", "xterm", 1);
        ::unsetenv("NO_COLOR");
        if (no_color != nullptr) ::setenv("NO_COLOR", no_color, 1);
        ::execl(ANOCTL, "anoctl", "decode", "AB DC FE 60 01 00 03 E9 51", nullptr);
        ::_exit(127);
    }
    std::string said;
    std::array<char, 1024> buffer;
    for (ssize_t n = 0; (n = ::read(terminal, buffer.data(), buffer.size())) > 0;)
        said.append(buffer.data(), static_cast<std::size_t>(n));
    ::close(terminal);
    ::waitpid(pid, nullptr, 0);
    return said;
}

long characters_of(const std::string& line) {
    return std::count_if(line.begin(), line.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
}

// The lines with frames, without colours. A terminal of a program such as `script` has no known height.
std::vector<std::string> monitored(const std::string& socket, unsigned short columns, unsigned short rows) {
    int terminal = -1;
    winsize size{};
    size.ws_col = columns;
    size.ws_row = rows;
    const pid_t pid = forkpty(&terminal, nullptr, nullptr, &size);
    if (pid == 0) {
        ::setenv("NO_COLOR", "1", 1);
        ::execl(ANOCTL, "anoctl", "--control", socket.c_str(), "monitor", "--count", "20", nullptr);
        ::_exit(127);
    }
    std::string said;
    std::array<char, 1024> buffer;
    for (ssize_t n = 0; (n = ::read(terminal, buffer.data(), buffer.size())) > 0;)
        said.append(buffer.data(), static_cast<std::size_t>(n));
    ::close(terminal);
    ::waitpid(pid, nullptr, 0);
    std::vector<std::string> lines;
    for (std::size_t at = 0, end = 0; (end = said.find("\r\n", at)) != said.npos; at = end + 2)
        if (said.compare(at, 7, "anoctl:") != 0) lines.push_back(said.substr(at, end - at));
    return lines;
}

TEST(AnoctlTerminal, monitor_cuts_its_lines_to_the_width) {
    const support::TempDir dir;
    support::Daemon daemon{ANOGATED, dir / "control.sock", {"sim:fc,name=fc"}};
    ASSERT_TRUE(daemon.until_answers());
    using Cells = unsigned short;
    for (const Cells columns : {Cells{40}, Cells{50}, Cells{60}, Cells{71}, Cells{200}})
        for (const Cells rows : {Cells{0}, Cells{24}}) {
            const auto lines = monitored(dir / "control.sock", columns, rows);
            ASSERT_EQ(lines.size(), 20u);
            for (const std::string& line : lines) EXPECT_LE(characters_of(line), columns) << line;
        }
}

TEST(AnoctlTerminal, has_colours_unless_no_color_is_set) {
    for (const char* no_color : {static_cast<const char*>(nullptr), ""})
        EXPECT_NE(on_a_terminal(no_color).find("\x1b["), std::string::npos);
    const std::string plain = on_a_terminal("1");
    EXPECT_EQ(plain.find("\x1b["), std::string::npos) << plain;
    EXPECT_NE(plain.find("waypoint_read"), std::string::npos) << plain;
}

}    // namespace
}    // namespace anoctl_pipes_tests
