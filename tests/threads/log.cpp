// A log that can't be written: a pipe without a reader, a stopped terminal, a file whose disk hangs. The gateway continues, and
// can be stopped.
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/sanitized.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace log_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

// ThreadSanitizer, not the program, prevents the end: without it, and with AddressSanitizer, the program ends.
constexpr char no_end_with_it[] = "a program that ThreadSanitizer watches does not end while a thread of it hangs in a write";

/// A named pipe that is full from the start.
class FullPipe {
public:
    explicit FullPipe(std::string path) : path_{std::move(path)} {
        if (::mkfifo(path_.c_str(), 0600) != 0) throw std::runtime_error{"no pipe"};
        fd_ = ::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
        ::fcntl(fd_, F_SETPIPE_SZ, 4096);
        const std::string filling(4096, '.');
        while (::write(fd_, filling.data(), filling.size()) > 0) {}
    }
    ~FullPipe() { ::close(fd_); }
    FullPipe(const FullPipe&) = delete;
    FullPipe& operator=(const FullPipe&) = delete;

    const std::string& path() const { return path_; }
    const std::string& heard() {
        char buffer[4096];
        for (ssize_t n; (n = ::read(fd_, buffer, sizeof buffer)) > 0;) heard_.append(buffer, static_cast<std::size_t>(n));
        return heard_;
    }
    bool until_says(const std::string& words) {
        return wait_until([&] { return heard().find(words) != std::string::npos; });
    }

private:
    std::string path_;
    int fd_ = -1;
    std::string heard_;
};

/// A terminal stopped with Ctrl-S.
class StoppedTerminal {
public:
    explicit StoppedTerminal(const std::string& path) : terminal_{path}, user_{path} {
        press(0x13);
        const Bytes probe{'.'};
        if (!wait_until([&] { return user_.write(probe) == 0; })) throw std::runtime_error{"the terminal goes on"};
    }
    const std::string& path() const { return terminal_.path(); }
    void go_on() { press(0x11); }
    bool until_says(const std::string& words) {
        return wait_until([&] {
            const Bytes& heard = terminal_.heard();
            return std::string{heard.begin(), heard.end()}.find(words) != std::string::npos;
        });
    }

private:
    void press(std::uint8_t key) { terminal_.write(Bytes{key}); }

    PtyDevice terminal_;
    PortUser user_;
};

/// A device, a ground station, and the gateway between them; its standard error is the file `path`.
class Joined {
public:
    explicit Joined(const TempDir& dir, const std::string& path, std::vector<std::string> arguments = {})
        : mcu{dir / "mcu"}, daemon{with_stderr(dir, path), dir / "control", with_links(std::move(arguments), mcu.path())} {}

    void frames_pass() {
        ASSERT_TRUE(daemon.until_up("mcu") && daemon.until_up("ground"));
        UdpPeer ground;
        ground.send(daemon.port("ground"), vendor::who_are_you);
        EXPECT_TRUE(wait_until([&] { return mcu.heard() == vendor::who_are_you; }));
        mcu.write(vendor::i_am_an_mcu);
        EXPECT_TRUE(wait_until([&] { return ground.heard() == vendor::i_am_an_mcu; }));
    }
    void ends() {
        const auto begin = std::chrono::steady_clock::now();
        EXPECT_TRUE(wait_until([&] {
            daemon.signal(SIGTERM);    // several signals have the same effect as one
            return !daemon.is_running();
        }));
        EXPECT_EQ(daemon.wait(), 0);
        EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
    }

    PtyDevice mcu;
    Daemon daemon;

private:
    static std::string with_stderr(const TempDir& dir, const std::string& path) {
        const std::string script = dir / "anogated";
        std::ofstream{script} << "#!/bin/sh\nexec " ANOGATED " \"$@\" 2>" << path << "\n";
        std::filesystem::permissions(script, std::filesystem::perms::owner_all);
        return script;
    }
    static std::vector<std::string> with_links(std::vector<std::string> arguments, const std::string& mcu) {
        arguments.insert(arguments.end(), {"serial:" + mcu, "udp-listen:127.0.0.1:0,name=ground"});
        return arguments;
    }
};

std::string config_with_log(const TempDir& dir, const std::string& file) {
    std::ofstream{dir / "config.json"} << R"({"log": {"file": ")" << file << R"("}})";
    return dir / "config.json";
}

TEST(BlockedLog, a_pipe_without_a_reader_delays_nothing) {
    if (thread_sanitized) GTEST_SKIP() << no_end_with_it;
    const TempDir dir;
    const FullPipe pipe{dir / "pipe"};
    Joined joined{dir, pipe.path()};
    joined.frames_pass();
    joined.ends();
}

TEST(BlockedLog, a_stopped_terminal_delays_nothing) {
    const TempDir dir;
    StoppedTerminal terminal{dir / "terminal"};
    Joined joined{dir, terminal.path()};
    joined.frames_pass();
    terminal.go_on();
    EXPECT_TRUE(terminal.until_says("mcu: up")) << "what was said meanwhile";
    joined.ends();
    EXPECT_TRUE(terminal.until_says("stopping (SIGTERM)"));
}

TEST(BlockedLog, a_terminal_that_stays_stopped_does_not_delay_the_end_of_the_program) {
    if (thread_sanitized) GTEST_SKIP() << no_end_with_it;
    const TempDir dir;
    const StoppedTerminal terminal{dir / "terminal"};
    Joined joined{dir, terminal.path()};
    ASSERT_TRUE(joined.daemon.until_up("mcu"));
    joined.ends();
}

// A terminal instead of a file: it exists, and writing to it blocks like a disk that hangs.
TEST(BlockedLog, a_file_that_accepts_no_data_delays_nothing) {
    if (thread_sanitized) GTEST_SKIP() << no_end_with_it;
    const TempDir dir;
    const StoppedTerminal file{dir / "file"};
    Joined joined{dir, "/dev/null", {"--config", config_with_log(dir, file.path())}};
    joined.frames_pass();
    joined.ends();
}

// Opening a file on which another process has a lease blocks until the lease is released.
TEST(BlockedLog, a_file_that_cannot_be_opened_yet_delays_nothing) {
    const TempDir dir;
    const std::string path = dir / "file";
    std::signal(SIGIO, SIG_IGN);
    const int lease = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (::fcntl(lease, F_SETLEASE, F_WRLCK) != 0) GTEST_SKIP() << "no leases here: " << std::strerror(errno);
    Joined joined{dir, "/dev/null", {"--config", config_with_log(dir, path)}};
    joined.frames_pass();
    EXPECT_TRUE(std::filesystem::is_empty(path));
    ::fcntl(lease, F_SETLEASE, F_UNLCK);
    EXPECT_TRUE(wait_until([&] {
        std::ifstream file{path};
        return std::string{std::istreambuf_iterator<char>{file}, {}}.find("mcu: up") != std::string::npos;
    }));
    joined.ends();
    ::close(lease);
}

TEST(BlockedLog, dropped_lines_are_reported_when_the_log_is_read_again) {
    const TempDir dir;
    FullPipe pipe{dir / "pipe"};
    std::vector<std::string> many;
    for (int i = 0; i < 20; ++i) many.push_back("serial:" + (dir / "absent") + std::to_string(i) + std::string(200, 'x'));
    Joined joined{dir, pipe.path(), many};
    joined.frames_pass();
    for (int i = 0; i < 40; ++i) {
        joined.daemon.signal(SIGUSR1);    // 5 kB
        ASSERT_NE(http(dir / "control", "GET /nothing HTTP/1.0\r\n\r\n"), "");
    }
    EXPECT_TRUE(pipe.until_says("log lines were dropped: the log destination did not accept them")) << pipe.heard().size();
    joined.daemon.signal(SIGHUP);
    EXPECT_TRUE(pipe.until_says("SIGHUP"));
    const std::string& said = pipe.heard();
    EXPECT_LT(said.find("anogated "), said.find("absent0x"));
    EXPECT_LT(said.find(" status\n"), said.find("log lines were dropped")) << "the first were kept";
    EXPECT_LT(said.find("log lines were dropped"), said.find("SIGHUP"));
    EXPECT_LT(said.size(), 180'000u) << "what waited had a bound";
    joined.daemon.signal(SIGTERM);
    EXPECT_TRUE(pipe.until_says("stopping (SIGTERM)"));
    EXPECT_EQ(joined.daemon.wait(), 0);
    EXPECT_EQ(pipe.heard().back(), '\n');
}

}    // namespace
}    // namespace log_tests
