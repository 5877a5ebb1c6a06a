// The control socket of a running daemon, with correct and faulty clients.
#include <support/child.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace control_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

const std::string get_status = "GET /status HTTP/1.0\r\n\r\n";

class ControlSocket : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(daemon.until_answers()) << daemon.output(); }
    void TearDown() override {
        daemon.signal(SIGTERM);
        EXPECT_EQ(daemon.wait(), 0) << daemon.output();
    }
    /// Whether frames are still forwarded from peer to peer.
    bool forwards() {
        const auto before = b.heard().size();
        a.send(daemon.port("ground"), frame(0xFE, 0xFF, 0xE0, {0, ++question, 0}));    // a repeat could count as a loop
        return wait_until([&] { return b.heard().size() > before; });
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"udp-listen:127.0.0.1:0,name=ground"}};
    UdpPeer a, b;
    std::uint8_t question = 0;
};

TEST_F(ControlSocket, answers_with_the_status_as_json) {
    const std::string answer = http(socket, get_status);
    EXPECT_EQ(answer.substr(0, 15), "HTTP/1.0 200 OK");
    EXPECT_NE(answer.find("Content-Type: application/json"), std::string::npos);
    EXPECT_TRUE(nlohmann::json::accept(body_of(answer)));
}

TEST_F(ControlSocket, one_connection_can_send_many_requests) {
    const int fd = connect_unix(socket);
    ASSERT_GE(fd, 0);
    std::string requests;
    for (int i = 0; i < 20; ++i) requests += "GET /status?n=" + std::to_string(i) + " HTTP/1.1\r\nHost: x\r\n\r\n";
    requests += "GET /status HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";
    ASSERT_EQ(::write(fd, requests.data(), requests.size()), static_cast<ssize_t>(requests.size()));
    const std::string answers = read_to_end(fd);
    ::close(fd);
    std::size_t count = 0;
    for (std::size_t at = 0; (at = answers.find("HTTP/1.1 200 OK", at)) != std::string::npos; ++at) ++count;
    EXPECT_EQ(count, 21u);
}

TEST_F(ControlSocket, a_head_request_is_answered_like_a_get_without_the_body) {
    const std::string answers = http(socket, "HEAD /status HTTP/1.1\r\nHost: x\r\n\r\nHEAD /nothing HTTP/1.0\r\n\r\n");
    EXPECT_TRUE(answers.starts_with("HTTP/1.1 200 OK")) << answers;
    EXPECT_EQ(answers.find('{'), std::string::npos) << answers;
    const auto length = answers.find("Content-Length: ");
    ASSERT_NE(length, std::string::npos) << answers;
    EXPECT_GT(std::stoul(answers.substr(length + 16)), 100u) << answers;
    EXPECT_NE(answers.find("\r\n\r\nHTTP/1.0 404"), std::string::npos) << answers;
}

TEST_F(ControlSocket, unknown_paths_and_methods_are_answered_with_the_right_error) {
    EXPECT_EQ(http(socket, "GET /nothing HTTP/1.0\r\n\r\n").substr(9, 3), "404");
    const std::string posted = http(socket, "POST /status HTTP/1.0\r\nContent-Length: 2\r\n\r\n{}");
    EXPECT_EQ(posted.substr(9, 3), "405");
    EXPECT_NE(posted.find("Allow: GET"), std::string::npos);
}

TEST_F(ControlSocket, the_error_for_an_unknown_path_suggests_the_nearest) {
    const auto error = [&](const std::string& path) {
        return nlohmann::json::parse(body_of(http(socket, "GET " + path + " HTTP/1.0\r\n\r\n"))).value("error", "");
    };
    EXPECT_EQ(error("/staus"), "this path does not exist (did you mean '/status'?)");
    EXPECT_EQ(error("/abcdefghijkl"), "this path does not exist; try /");
}

TEST_F(ControlSocket, invalid_data_is_answered_with_an_error_and_does_not_disturb_forwarding) {
    a.send(daemon.port("ground"), vendor::who_are_you);
    b.send(daemon.port("ground"), vendor::who_are_you);
    const auto has_error = [&](const std::string& junk, const std::string& status) {
        const std::string answer = http(socket, junk);
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 " + status)) << answer;
        EXPECT_TRUE(nlohmann::json::parse(body_of(answer), nullptr, false).value("error", "") != "") << answer;
    };
    has_error("\r\n\r\n\x01\x02 HELLO WHO IS THERE\r\n\r\n", "400 Bad Request");
    has_error(std::string(100000, '\0'), "400 Bad Request");
    has_error("GET /status HTTP/1.1\r\nX: " + std::string(200000, 'x') + "\r\n\r\n", "431 Request Header Fields Too Large");
    has_error("POST /status HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\nx", "413 Payload Too Large");
    has_error("POST /status HTTP/1.1\r\nContent-Length: -1\r\n\r\nx", "400 Bad Request");
    EXPECT_TRUE(forwards());
    EXPECT_TRUE(nlohmann::json::accept(body_of(http(socket, get_status))));
}

TEST_F(ControlSocket, slow_and_silent_clients_disturb_nobody) {
    a.send(daemon.port("ground"), vendor::who_are_you);
    b.send(daemon.port("ground"), vendor::who_are_you);
    std::vector<int> fds;
    for (int i = 0; i < 20; ++i) {
        fds.push_back(connect_unix(socket));
        ASSERT_GE(fds.back(), 0);
        if (i % 2 == 0) {
            ASSERT_EQ(::write(fds.back(), "GET /sta", 8), 8);
        }
    }
    EXPECT_TRUE(forwards());
    EXPECT_TRUE(nlohmann::json::accept(body_of(http(socket, get_status))));
    // A client that sends many requests and never reads the answers.
    const int greedy = connect_unix(socket);
    ::fcntl(greedy, F_SETFL, O_NONBLOCK);
    std::string many;
    for (int i = 0; i < 2000; ++i) many += "GET /status HTTP/1.1\r\nHost: x\r\n\r\n";
    for (std::size_t sent = 0; sent < many.size();) {
        const ssize_t n = ::send(greedy, many.data() + sent, many.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) break;
        sent += static_cast<std::size_t>(n);
    }
    EXPECT_TRUE(forwards());
    for (const int fd : fds) ::close(fd);
    ::close(greedy);
}

TEST_F(ControlSocket, survives_many_connections_at_once) {
    a.send(daemon.port("ground"), vendor::who_are_you);
    b.send(daemon.port("ground"), vendor::who_are_you);
    std::vector<int> fds;
    for (int i = 0; i < 200; ++i) fds.push_back(connect_unix(socket));
    EXPECT_TRUE(daemon.is_running());
    for (const int fd : fds)
        if (fd >= 0) ::close(fd);
    EXPECT_TRUE(daemon.until_answers()) << "the places are free again";
    EXPECT_TRUE(forwards());
}

TEST_F(ControlSocket, is_accessible_only_to_its_user_if_there_is_no_group) {
    if (::getgrnam("anogate")) GTEST_SKIP() << "this system has a group anogate";
    struct stat info {};
    ASSERT_EQ(::stat(socket.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0600u);
    std::filesystem::create_directory(dir / "open");
    std::filesystem::permissions(dir / "open", std::filesystem::perms{0755});
    Daemon other{ANOGATED, dir / "open/control.sock", {"sim:fc"}};
    EXPECT_TRUE(other.until_says("accessible to this user only"));
    other.signal(SIGTERM);
    EXPECT_EQ(other.wait(), 0);
}

TEST_F(ControlSocket, logs_no_access_note_in_a_folder_closed_to_other_users) {
    EXPECT_EQ(daemon.output().find("accessible to this user only"), std::string::npos) << daemon.output();
}

TEST_F(ControlSocket, a_second_daemon_reports_the_conflict_and_the_first_keeps_its_socket) {
    Daemon second{ANOGATED, socket, {"sim:fc"}};
    EXPECT_TRUE(second.until_says("another program is using it")) << second.output();
    second.signal(SIGTERM);
    EXPECT_EQ(second.wait(), 0);
    EXPECT_EQ(daemon.link("ground").at("state"), "up") << "the socket is still that of the first";
}

TEST_F(ControlSocket, an_existing_file_at_its_path_is_kept_and_reported) {
    const TempDir other;
    std::ofstream{other / "file"} << "precious";
    Daemon second{ANOGATED, other / "file", {"sim:fc"}};
    EXPECT_TRUE(second.until_says("file: exists and is not a socket (use --control with another path")) << second.output();
    EXPECT_TRUE(std::filesystem::is_regular_file(other / "file"));
}

TEST_F(ControlSocket, is_removed_at_the_end_without_waiting_for_open_connections) {
    const int idle = connect_unix(socket);
    const int half = connect_unix(socket);
    ASSERT_EQ(::write(half, "GET /st", 7), 7);
    ASSERT_TRUE(daemon.until_answers());
    const auto begin = std::chrono::steady_clock::now();
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
    EXPECT_FALSE(std::filesystem::exists(socket));
    ::close(idle);
    ::close(half);
}

TEST(ControlSocketAtStart, replaces_the_socket_of_a_killed_process) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    {
        Daemon killed{ANOGATED, socket, {"sim:fc"}};
        ASSERT_TRUE(killed.until_answers());
        killed.signal(SIGKILL);
        killed.wait();
    }
    ASSERT_TRUE(std::filesystem::exists(socket));
    Daemon next{ANOGATED, socket, {"sim:fc"}};
    EXPECT_TRUE(next.until_answers()) << next.output();
}

TEST(ControlSocketAtStart, fails_if_the_configured_path_cannot_be_used) {
    const TempDir dir;
    std::ofstream{dir / "file"} << "precious";
    for (const auto& [path, words] :
         {std::pair{"file", "exists and is not a socket"}, {"rnu/control.sock", "there is no folder"}}) {
        Daemon daemon{ANOGATED, dir / path, {"sim:fc"}};
        EXPECT_EQ(daemon.wait(), 78);
        EXPECT_TRUE(daemon.output().starts_with("anogated: --control: " + (dir / path) + ": " + words)) << daemon.output();
    }
    Daemon nowhere{ANOGATED, "/proc/control.sock", {"sim:fc"}};    // even root can't create a socket there; only trying shows it
    EXPECT_EQ(nowhere.wait(), 78);
    EXPECT_NE(nowhere.output().find("--control: /proc/control.sock: "), std::string::npos) << nowhere.output();
    EXPECT_TRUE(std::filesystem::is_regular_file(dir / "file"));
    EXPECT_FALSE(std::filesystem::exists(dir / "rnu")) << "what was mistyped is not made";
}

TEST(ControlSocketAtStart, is_not_required_if_the_default_path_cannot_be_used) {
    if (::geteuid() == 0) GTEST_SKIP() << "root's is in /run/anogate";
    const TempDir dir;
    Process daemon{ANOGATED, {"sim:fc"}, {"XDG_RUNTIME_DIR=/proc/nonexistent"}};
    EXPECT_TRUE(daemon.until_says("no control interface")) << daemon.output();
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
}

TEST(ControlSocketAtStart, creates_its_default_folder) {
    const TempDir dir;
    const std::string folder = "XDG_RUNTIME_DIR=" + dir.path().string();
    Daemon daemon{ANOGATED, dir / "anogate/control.sock", {"sim:fc"}, {folder}};
    EXPECT_TRUE(daemon.until_answers()) << daemon.output();
}

TEST(ControlSocketAtStart, waits_for_a_socket_in_use) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    Daemon first{ANOGATED, socket, {"sim:fc,name=first"}};
    ASSERT_TRUE(first.until_answers()) << first.output();
    Daemon second{ANOGATED, socket, {"sim:fc,name=second"}};
    ASSERT_TRUE(second.until_says("another program is using it (use --control with another path); waiting for it"))
        << second.output();
    first.signal(SIGTERM);
    EXPECT_EQ(first.wait(), 0);
    EXPECT_TRUE(second.until_says(socket + ": up")) << second.output();
    EXPECT_EQ(second.link("second").at("state"), "up");
    second.signal(SIGTERM);
    EXPECT_EQ(second.wait(), 0);
    EXPECT_FALSE(std::filesystem::exists(socket));
}

TEST(ControlSocketAtStart, passes_from_one_daemon_to_the_next_however_the_previous_one_ended) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    Daemon first{ANOGATED, socket, {"sim:fc"}};
    ASSERT_TRUE(first.until_answers()) << first.output();
    Daemon second{ANOGATED, socket, {"sim:fc"}}, third{ANOGATED, socket, {"sim:fc"}};
    ASSERT_TRUE(second.until_says("waiting for it")) << second.output();
    ASSERT_TRUE(third.until_says("waiting for it")) << third.output();
    const std::string up = socket + ": up";
    const auto has_it = [&](Daemon& daemon) { return daemon.output().find(up) != std::string::npos; };
    first.signal(SIGKILL);
    ASSERT_TRUE(wait_until([&] { return has_it(second) || has_it(third); })) << second.output() << third.output();
    EXPECT_TRUE(second.until_answers());
    EXPECT_FALSE(has_it(second) && has_it(third));
    Daemon& next = has_it(second) ? second : third;
    Daemon& last = has_it(second) ? third : second;
    next.signal(SIGTERM);
    EXPECT_TRUE(last.until_says(up)) << last.output();
    EXPECT_EQ(next.wait(), 0);
    EXPECT_TRUE(last.until_answers()) << "what ended last took away its own socket alone";
}

TEST(ControlSocketAtStart, reports_a_path_that_is_too_long) {
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / std::string(120, 'x'), {"sim:fc"}};
    EXPECT_EQ(daemon.wait(), 78);
    EXPECT_NE(daemon.output().find("107 bytes"), std::string::npos) << daemon.output();
}

}    // namespace
}    // namespace control_tests
