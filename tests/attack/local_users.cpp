// Other local processes: greedy and idle clients of the control socket, clients of other users, folders of other users.
// tests/README.md has the figures.
#include <http/server.hpp>
#include <status/status.hpp>
#include <support/child.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/sanitized.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <sys/asio.hpp>
#include <sys/files/path_lock.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <fstream>

namespace local_users_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::http::Request;
using anogate::http::Response;
using anogate::http::Server;
namespace fs = std::filesystem;

constexpr uid_t nobody = 65534;
constexpr int places = 44;    // of clients of the Unix socket

const std::string get_status = "GET /status HTTP/1.1\r\nHost: x\r\n\r\n";

/// A client of the control socket that never waits.
class Client {
public:
    explicit Client(const std::string& socket) : fd_{connect_unix(socket)} { ::fcntl(fd_.get(), F_SETFL, O_NONBLOCK); }
    bool is_connected() const { return static_cast<bool>(fd_); }
    bool send(const std::string& text) {
        return ::send(fd_.get(), text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
    }
    bool ask(int requests) {
        std::string text;
        for (int i = 0; i < requests; ++i) text += get_status;
        return send(text);
    }
    const std::string& heard() {
        char buffer[65536];
        ssize_t n;
        while ((n = ::read(fd_.get(), buffer, sizeof buffer)) > 0) heard_.append(buffer, static_cast<std::size_t>(n));
        cut_off_ = cut_off_ || (n < 0 && errno != EAGAIN && errno != EINTR);
        closed_ = closed_ || n == 0 || cut_off_;
        return heard_;
    }
    std::size_t answers() {
        std::size_t count = 0;
        for (std::size_t at = 0; (at = heard().find("HTTP/1.1 200 OK", at)) != std::string::npos; ++at) ++count;
        return count;
    }
    bool is_closed() { return heard(), closed_; }
    /// Checked before the end could be read: the rest may be lost.
    bool is_cut_off() { return heard(), cut_off_; }

private:
    anogate::UniqueFd fd_;
    std::string heard_;
    bool closed_ = false;
    bool cut_off_ = false;
};

/// A gateway with its control socket, in the thread of the test.
class LocalUsers : public testing::Test {
protected:
    void SetUp() override {
        const auto with_body = [](std::string body) {
            Response response;
            response.body = std::move(body);
            return response;
        };
        // More than the socket of a client can store.
        control.routes().add("GET", "/big", [=](const Request&) { return with_body(std::string(1 << 20, ' ')); });
        control.routes().add("GET", "/status", [=, this](const Request&) {
            on_request();
            return with_body(anogate::status_json(gateway.gateway()));
        });
        ASSERT_EQ(control.start(socket).error, "");
    }
    void TearDown() override {
        control.stop();
        gateway.stop(0ms);
    }
    std::unique_ptr<Client> connect() {
        auto client = std::make_unique<Client>(socket);
        settle();
        return client;
    }
    void settle() {
        gateway.io().restart();
        gateway.io().poll();
    }
    bool is_answered(Client& client) {
        return client.ask(1) && gateway.until([&] { return client.answers() == 1 || client.is_closed(); }) &&
               client.answers() == 1;
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    RunningGateway gateway{udp_listen("ground")};
    Server control{gateway.io()};
    std::function<void()> on_request = [] {};
};

/// A command is sent with every request; counts the commands of earlier requests that had not arrived when the next was answered.
class GreedyClients : public LocalUsers {
protected:
    void SetUp() override {
        LocalUsers::SetUp();
        pilot.send(gateway.port("ground"), frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
        fc.send(gateway.port("ground"), frame(0xDC, 0xFE, 0xF1, {0}));
        ASSERT_TRUE(gateway.until([&] { return gateway.link("ground").at("channels").size() == 2; }));
        fc.forget();
        on_request = [this] {
            max_behind = std::max(max_behind, sent - arrived());
            const auto low = static_cast<std::uint8_t>(sent), high = static_cast<std::uint8_t>(sent >> 8);
            pilot.send(gateway.port("ground"), frame(0xFE, 0xDC, 0xC0, {16, high, low}));
            ++sent;
        };
    }
    std::size_t arrived() { return fc.heard().size() / frame(0xFE, 0xDC, 0xC0, {16, 0, 0}).size(); }
    void serve(std::size_t clients, int requests) {
        std::vector<std::unique_ptr<Client>> greedy;
        for (std::size_t i = 0; i < clients; ++i) greedy.push_back(connect());
        for (auto& client : greedy) ASSERT_TRUE(client->ask(requests));
        EXPECT_TRUE(gateway.until([&] {
            for (auto& client : greedy) client->heard();
            return sent == clients * static_cast<std::size_t>(requests);
        })) << sent;
        for (auto& client : greedy)
            EXPECT_TRUE(gateway.until([&] { return client->answers() == static_cast<std::size_t>(requests); }))
                << client->answers();
        EXPECT_TRUE(gateway.until([&] { return arrived() == sent; })) << arrived();
    }

    UdpPeer pilot, fc;
    std::size_t sent = 0;
    std::size_t max_behind = 0;
};

TEST_F(GreedyClients, one_with_200_requests_lets_every_command_pass_between_them) {
    serve(1, 200);
    EXPECT_LE(max_behind, 1u);
}

TEST_F(GreedyClients, sixteen_with_5_requests_each_let_every_command_pass_between_them) {
    serve(16, 5);
    EXPECT_LE(max_behind, 1u);
}

TEST_F(LocalUsers, many_idle_clients_do_not_keep_the_next_one_waiting) {
    std::vector<std::unique_ptr<Client>> idle;
    for (int i = 0; i < places + 8; ++i) idle.push_back(connect());
    const auto next = connect();
    EXPECT_TRUE(is_answered(*next));
    EXPECT_TRUE(idle.front()->is_closed()) << "the one that was idle the longest";
    EXPECT_FALSE(idle.back()->is_closed());
    EXPECT_TRUE(is_answered(*idle.back())) << "it asks when it likes";
}

TEST_F(LocalUsers, client_with_half_a_request_is_closed_for_one_with_a_whole_request) {
    std::vector<std::unique_ptr<Client>> half;
    for (int i = 0; i < places; ++i) {
        half.push_back(connect());
        ASSERT_TRUE(half.back()->send("GET /sta"));
    }
    settle();
    const auto next = connect();
    EXPECT_TRUE(is_answered(*next));
    EXPECT_TRUE(half.front()->heard().starts_with("HTTP/1.1 503 Service Unavailable")) << "and is told";
    EXPECT_TRUE(half.front()->is_closed() && !half.front()->is_cut_off());
    EXPECT_FALSE(half.back()->is_closed());
}

TEST_F(LocalUsers, client_that_has_sent_nothing_yet_is_not_closed_for_others_with_half_a_request) {
    std::vector<std::unique_ptr<Client>> half;
    const auto slow = connect();
    for (int i = 0; i < 100; ++i) {
        half.push_back(connect());
        ASSERT_TRUE(half.back()->send("GET /sta"));
    }
    EXPECT_FALSE(slow->is_closed());
    EXPECT_TRUE(is_answered(*slow));
}

TEST_F(LocalUsers, a_new_client_waits_instead_of_cutting_short_a_busy_one_of_the_same_user) {
    std::vector<std::unique_ptr<Client>> busy;
    for (int i = 0; i < places; ++i) {
        busy.push_back(connect());
        ASSERT_TRUE(busy.back()->send("GET /big HTTP/1.1\r\nHost: x\r\n\r\n"));
        settle();
    }
    const auto next = connect();
    EXPECT_TRUE(next->is_connected());
    EXPECT_TRUE(is_answered(*next)) << "when the first of them has read nothing for a second";
    for (const auto& client : busy) client->heard();
    EXPECT_EQ(std::count_if(busy.begin(), busy.end(), [](const auto& client) { return client->is_closed(); }), 1);
}

TEST_F(LocalUsers, refused_clients_that_stay_connected_use_few_descriptors_and_not_for_long) {
    const auto open = [] { return std::distance(fs::directory_iterator{"/proc/self/fd"}, fs::directory_iterator{}); };
    const auto before = open();
    std::vector<std::unique_ptr<Client>> stay;
    for (int i = 0; i < 300; ++i) {
        stay.push_back(connect());
        ASSERT_TRUE(stay.back()->send("GET /sta"));
        settle();
    }
    EXPECT_LE(open() - before - 300, places + 32) << "those with a place, and those who are being told";
    EXPECT_TRUE(gateway.until([&] { return open() - before - 300 <= places; }));
}

/// A process of the same user floods the gateway: it connects, sends half a request, and repeats that.
class Flooded : public LocalUsers {
protected:
    int flood() {
        std::deque<Client> held;
        for (;;) {
            held.emplace_back(socket);
            held.back().send("GET /sta");
            if (held.size() > 64) held.pop_front();
        }
    }
    /// How many of 60 complete requests, sent one after the other, are not answered.
    int failures() {
        int failed = 0;
        for (int i = 0; i < 60; ++i) failed += http(socket, "GET /status HTTP/1.0\r\n\r\n").starts_with("HTTP/1.0 200") ? 0 : 1;
        return failed;
    }
    bool has_ended(const Child& child) {
        siginfo_t info{};
        return ::waitid(P_PID, static_cast<id_t>(child.pid()), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
    }
};

TEST_F(Flooded, every_whole_request_is_answered) {
    const Child first{[&] { return flood(); }}, second{[&] { return flood(); }};
    Child asks{[&] { return failures(); }};
    ASSERT_TRUE(gateway.until([&] { return has_ended(asks); }, 30s));
    EXPECT_EQ(asks.wait(), 0);
}

/// With clients of another user, in a separate process.
class TwoUsers : public LocalUsers {
protected:
    void SetUp() override {
        if (::geteuid() != 0) GTEST_SKIP() << "needs root, to be another user as well";
        LocalUsers::SetUp();
        fs::permissions(dir.path(), fs::perms{0711});
        fs::permissions(socket, fs::perms{0666});    // as if all users were in the group
        ASSERT_EQ(::pipe(ready), 0);
    }
    void TearDown() override {
        if (::geteuid() != 0) return;
        LocalUsers::TearDown();
        ::close(ready[0]);
        ::close(ready[1]);
    }
    /// `clients` of them send requests and don't read; then one sends a request and reads, and the process exits with 0 if it is
    /// answered.
    int theirs(int clients) {
        if (!become_nobody()) return 1;
        std::vector<int> fds;
        for (int i = 0; i < clients; ++i) {
            fds.push_back(connect_unix(socket));
            constexpr std::string_view ask = "GET /big HTTP/1.1\r\nHost: x\r\n\r\n";
            if (::send(fds.back(), ask.data(), ask.size(), MSG_NOSIGNAL) != ssize_t(ask.size())) return 2;
        }
        if (::write(ready[1], "r", 1) != 1) return 3;
        if (clients == 0) return http(socket, "GET /status HTTP/1.0\r\n\r\n").starts_with("HTTP/1.0 200") ? 0 : 4;
        return ::pause();
    }
    bool is_ready() {
        pollfd fd{ready[0], POLLIN, 0};
        return ::poll(&fd, 1, 0) == 1;
    }

    int ready[2]{};
};

TEST_F(TwoUsers, busy_clients_of_another_user_leave_our_user_its_share) {
    const Child other{[&] { return theirs(places); }};
    ASSERT_TRUE(gateway.until([&] { return is_ready(); }));
    settle();
    for (int i = 0; i < 3; ++i) {
        const auto ours = connect();
        EXPECT_TRUE(is_answered(*ours)) << i;
    }
}

TEST_F(TwoUsers, busy_clients_of_our_user_leave_another_user_its_share) {
    std::vector<std::unique_ptr<Client>> ours;
    for (int i = 0; i < places; ++i) {
        ours.push_back(connect());
        ASSERT_TRUE(ours.back()->send("GET /big HTTP/1.1\r\nHost: x\r\n\r\n"));
        settle();
    }
    Child other{[&] { return theirs(0); }};
    const auto has_ended = [&] {
        siginfo_t info{};
        return ::waitid(P_PID, static_cast<id_t>(other.pid()), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
    };
    ASSERT_TRUE(gateway.until(has_ended));
    EXPECT_EQ(other.wait(), 0);
}

/// Root creates its files in a folder that belongs to another user.
class ForeignFolder : public testing::Test {
protected:
    void SetUp() override {
        if (::geteuid() != 0) GTEST_SKIP() << "needs root, to be another user as well";
        fs::permissions(dir.path(), fs::perms{0755});
        fs::create_directory(theirs);
        fs::create_directory(ours);
        ASSERT_EQ(::chown(theirs.c_str(), nobody, nobody), 0);
        std::ofstream{precious} << "precious";
        ASSERT_EQ(::chmod(precious.c_str(), 0640), 0);
    }
    mode_t mode_of_precious() {
        struct stat info {};
        ::stat(precious.c_str(), &info);
        return info.st_mode & 0777;
    }
    std::string swap() { return theirs + "/swap"; }
    /// Whatever root creates at `path` is replaced at once by a link to the precious file.
    int swap_for_ever(const std::string& path) {
        const int made = ::inotify_init1(IN_CLOEXEC);
        if (!become_nobody() || ::inotify_add_watch(made, theirs.c_str(), IN_CREATE) < 0) return 1;
        for (alignas(inotify_event) char event[4096];;) {
            if (::symlink(precious.c_str(), swap().c_str()) != 0) return 2;
            do {
                if (::read(made, event, sizeof event) <= 0) return 3;
            } while (!fs::is_socket(fs::symlink_status(path)) || ::rename(swap().c_str(), path.c_str()) != 0);
        }
    }
    TempDir dir;
    std::string theirs = dir / "theirs", ours = dir / "ours", precious = dir / "ours/precious";
    anogate::asio::io_context io{1};
};

TEST_F(ForeignFolder, swapping_the_socket_for_a_link_does_not_make_root_change_another_files_mode) {
    const std::string socket = theirs + "/control.sock";
    const Child swapper{[&] { return swap_for_ever(socket); }};
    int changed = 0;
    for (int i = 0; i < 293; ++i) {
        ASSERT_TRUE(wait_until([&] { return fs::is_symlink(fs::symlink_status(swap())); }, patience, [] { ::usleep(100); }));
        Server control{io};
        control.start(socket);
        control.stop();
        io.restart();
        io.poll();
        fs::remove(socket);
        if (mode_of_precious() == 0640) continue;
        ++changed;
        ::chmod(precious.c_str(), 0640);
    }
    EXPECT_EQ(changed, 0);
    EXPECT_TRUE(fs::is_regular_file(precious));
}

TEST_F(ForeignFolder, files_that_root_creates_there_are_reachable_and_belong_to_root) {
    const std::string socket = theirs + "/control.sock";
    {
        Server control{io};
        ASSERT_EQ(control.start(socket).error, "");
        struct stat info {};
        ASSERT_EQ(::lstat(socket.c_str(), &info), 0);
        EXPECT_EQ(info.st_uid, 0u);
        EXPECT_EQ(info.st_mode & 0007, 0u) << "nor is it everybody's";
        const int fd = connect_unix(socket);
        EXPECT_GE(fd, 0);
        ::close(fd);
        RunningGateway gateway{pty("app", theirs + "/app")};
        EXPECT_EQ(fs::read_symlink(theirs + "/app"), gateway.link("app").at("device").get<std::string>());
    }
    EXPECT_TRUE(fs::is_empty(theirs));
}

TEST_F(ForeignFolder, a_symbolic_link_of_another_user_in_the_path_is_not_followed) {
    ASSERT_EQ(::symlink(ours.c_str(), (theirs + "/way").c_str()), 0);
    ASSERT_EQ(::lchown((theirs + "/way").c_str(), nobody, nobody), 0);
    Server control{io};
    EXPECT_NE(control.start(theirs + "/way/control.sock").error.find("leads through way, a symbolic link of another user"),
              std::string::npos);
    RunningGateway gateway{pty("app", theirs + "/way/app")};
    EXPECT_EQ(gateway.link("app").at("error"),
              theirs + "/way/app: leads through way, a symbolic link of another user, which is not followed");
    EXPECT_FALSE(fs::exists(fs::symlink_status(ours + "/app")));
    EXPECT_FALSE(fs::exists(ours + "/control.sock"));
}

TEST_F(ForeignFolder, a_socket_of_another_user_is_left_alone_whether_in_use_or_not) {
    const std::string socket = theirs + "/control.sock";
    Child other{[&] {
        Server control{io};
        return become_nobody() && control.start(socket).error.empty() ? ::pause() : 1;
    }};
    ASSERT_TRUE(wait_until([&] { return fs::exists(socket); }));
    Server control{io};
    ASSERT_TRUE(wait_until([&] { return control.start(socket).in_use; }));
    ::kill(other.pid(), SIGKILL);
    other.wait();
    EXPECT_EQ(control.start(socket).error,
              socket + ": is a socket of another user and is left alone (use --control with another path)");
    EXPECT_TRUE(fs::exists(socket));
}

TEST_F(ForeignFolder, a_symbolic_link_of_another_user_at_a_pty_path_is_left_alone) {
    const std::string app = theirs + "/app";
    ASSERT_EQ(::symlink("/dev/pts/99999", app.c_str()), 0);
    ASSERT_EQ(::lchown(app.c_str(), nobody, nobody), 0);
    RunningGateway gateway{pty("app", app)};
    EXPECT_EQ(gateway.link("app").at("error"),
              app + " is a symbolic link of another user and is left alone; choose another path");
    EXPECT_EQ(fs::read_symlink(app), "/dev/pts/99999");
    fs::remove(app);
    EXPECT_TRUE(gateway.until([&] { return fs::is_symlink(app); })) << "the way is free now";
}

TEST_F(ForeignFolder, a_file_that_others_put_next_to_a_pty_path_is_left_alone) {
    std::ofstream{theirs + "/app.anogate-new"} << "somebody's";
    RunningGateway gateway{pty("app", theirs + "/app")};
    EXPECT_TRUE(fs::is_symlink(theirs + "/app"));
    EXPECT_TRUE(fs::is_regular_file(theirs + "/app.anogate-new"));
}

// Any user can have it: a name in the kernel that belongs to its first user.
TEST_F(ForeignFolder, a_pty_path_is_not_blocked_by_a_socket_name_that_any_user_can_bind) {
    struct stat folder {};
    ASSERT_EQ(::stat(theirs.c_str(), &folder), 0);
    const std::string name = "anogate-pty " + std::to_string(folder.st_dev) + " " + std::to_string(folder.st_ino) + " " +
                             std::to_string(std::hash<std::string>{}("app"));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
    const anogate::UniqueFd blocker{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    ASSERT_EQ(::bind(blocker.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    RunningGateway gateway{pty("app", theirs + "/app")};
    EXPECT_TRUE(fs::is_symlink(theirs + "/app")) << gateway.link("app").at("error");
}

// Without /run/anogate and $XDG_RUNTIME_DIR the lock is beside the path, where other users may have created files.
TEST_F(ForeignFolder, files_of_other_users_at_a_lock_path_do_not_block_locking) {
    fs::create_directory(dir / "tmp");
    ASSERT_EQ(::chmod((dir / "tmp").c_str(), 01777), 0);
    const auto locks = [&] { return std::distance(fs::directory_iterator{dir / "tmp"}, fs::directory_iterator{}); };
    const auto as_nobody = [&](const std::function<int()>& work) {
        return Child{[&] { return ::unsetenv("XDG_RUNTIME_DIR") == 0 && become_nobody() ? work() : 100; }}.wait();
    };
    if (::access("/run/anogate", W_OK) == 0 && as_nobody([] { return ::access("/run/anogate", W_OK) == 0 ? 1 : 0; }) != 0)
        GTEST_SKIP() << "everybody may write to /run/anogate here";
    std::string lock;
    EXPECT_EQ(as_nobody([&] {
                  anogate::PathLock one, other;
                  if (!one.acquire(dir / "tmp/app") || locks() != 1) return 1;
                  if (const auto taken = other.acquire(dir / "tmp/../tmp/app"); taken || !taken.error().in_use) return 2;
                  if (!one.acquire(dir / "tmp/app")) return 3;
                  one.release();
                  if (locks() != 0) return 4;
                  if (!other.acquire(dir / "tmp/app")) return 5;
                  ::_exit(0);    // as if killed: the file stays
              }),
              0);
    ASSERT_EQ(locks(), 1);
    lock = fs::directory_iterator { dir / "tmp" } -> path();
    EXPECT_EQ(as_nobody([&] { return anogate::PathLock{}.acquire(dir / "tmp/app") ? 0 : 1; }), 0)
        << "the file of a process that was killed";
    EXPECT_EQ(locks(), 0);
    ASSERT_EQ(::symlink(precious.c_str(), lock.c_str()), 0);
    EXPECT_EQ(as_nobody([&] { return anogate::PathLock{}.acquire(dir / "tmp/app") ? 0 : 1; }), 0)
        << "a symbolic link that root created";
    fs::remove(lock);
    std::ofstream{lock} << "root's";
    EXPECT_EQ(as_nobody([&] { return anogate::PathLock{}.acquire(dir / "tmp/app") ? 0 : 1; }), 0) << "a file that root created";
    EXPECT_TRUE(fs::is_regular_file(lock));
}

TEST_F(ForeignFolder, locks_of_a_user_are_in_the_runtime_folder_of_that_user_only) {
    const std::string own = theirs + "/own";
    ASSERT_TRUE(fs::create_directory(own) && ::chown(own.c_str(), nobody, nobody) == 0);
    fs::create_directory(dir / "open");
    ASSERT_EQ(::chmod((dir / "open").c_str(), 01777), 0);
    const auto as_nobody = [&](const std::string& runtime_dir) {
        return Child{[&] {
                   if (!become_nobody() || ::setenv("XDG_RUNTIME_DIR", runtime_dir.c_str(), 1) != 0) return 1;
                   if (::access("/run/anogate", W_OK) == 0) return 2;
                   if (!anogate::PathLock{}.acquire(dir / "open/app")) return 3;
                   anogate::PathLock claim;
                   claim.acquire(dir / "open/app");
                   return fs::is_empty(dir / "open") ? 10 : 11;
               }}
            .wait();
    };
    EXPECT_EQ(as_nobody(own), 10);
    EXPECT_EQ(as_nobody(ours), 11) << "another user's is not used: the lock is beside the path";
}

/// The locations of a user's lock files.
class LockFiles : public testing::Test {
protected:
    void SetUp() override {
        fs::permissions(dir.path(), fs::perms{0755});
        fs::create_directory(own);
        if (::geteuid() == 0) {
            ASSERT_EQ(::chown(own.c_str(), nobody, nobody), 0);
        }
    }
    /// The result of `work`, run by a user whose locks are in a folder of its own; 100: there is no such user here.
    int as_user(const std::function<int()>& work) {
        return Child{[&] {
                   if (::geteuid() == 0 && !become_nobody()) return 100;
                   if (::access("/run/anogate", W_OK) == 0 || ::setenv("XDG_RUNTIME_DIR", own.c_str(), 1) != 0) return 100;
                   return work();
               }}
            .wait();
    }
    auto locks() { return std::distance(fs::directory_iterator{own + "/anogate"}, fs::directory_iterator{}); }
    /// Locks `name` and ends as if killed. Its result is whether it had the lock, and that of `inside`, which ran with the lock.
    int killed_with(
        const std::string& name, const std::function<int()>& inside = [] { return 0; }) {
        return Child{[&]() -> int {
                   anogate::PathLock claim;
                   ::_exit(claim.acquire(dir / name) ? inside() : 50);
               }}
            .wait();
    }
    TempDir dir;
    std::string own = dir / "own";
};

TEST_F(LockFiles, of_killed_processes_are_removed_and_held_ones_are_kept) {
    const int result = as_user([&] {
        anogate::PathLock held, next;
        if (!held.acquire(dir / "held")) return 1;
        if (killed_with("a", [&] { return killed_with("b") + killed_with("held"); }) != 50)
            return 2;    // a is held while b is locked
        std::ofstream{own + "/anogate/notes"} << "no lock of ours";
        if (locks() != 4) return 3;
        if (!next.acquire(dir / "next")) return 4;
        if (locks() != 3) return 5;
        return killed_with("held") == 50 && killed_with("next") == 50 ? 0 : 6;
    });
    if (result == 100) GTEST_SKIP() << "needs a user who may not write to /run/anogate";
    EXPECT_EQ(result, 0);
}

TEST_F(LockFiles, are_never_held_twice_while_others_remove_stale_ones) {
    const int result = as_user([&] {
        std::vector<std::unique_ptr<Child>> others, takers;
        for (const std::string name : {"x", "y"})
            others.push_back(std::make_unique<Child>([&, name]() -> int {
                for (;;) anogate::PathLock{}.acquire(dir / name);
            }));
        const auto alone = [&] {
            const int marker = ::open((own + "/marker").c_str(), O_CREAT | O_EXCL | O_CLOEXEC, 0600);
            return marker >= 0 && ::sched_yield() == 0 && ::unlink((own + "/marker").c_str()) == 0 ? 0 : 1;
        };
        for (int i = 0; i < 3; ++i)
            takers.push_back(std::make_unique<Child>([&] {
                int had = 0;
                for (int round = 0; round < (sanitized ? 20 : 200); ++round) {
                    const int outcome = killed_with("app", alone);
                    if (outcome != 0 && outcome != 50) return outcome;
                    had += outcome == 0 ? 1 : 0;
                }
                return had > 0 ? 0 : 2;
            }));
        for (const auto& taker : takers)
            if (const int failed = taker->wait(); failed != 0) return failed;
        return 0;
    });
    if (result == 100) GTEST_SKIP() << "needs a user who may not write to /run/anogate";
    EXPECT_EQ(result, 0) << "1: two had it at once; 2: somebody never had it";
}

/// Several gateways of the same user.
class Instances : public testing::Test {
protected:
    TempDir dir;
    std::string socket = dir / "control.sock";
    anogate::asio::io_context io{1};
};

TEST_F(Instances, a_stopping_one_removes_only_the_socket_that_it_created) {
    Server ending{io};
    ASSERT_EQ(ending.start(socket).error, "");
    fs::rename(socket, dir / "aside");
    const int another = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socket.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(another, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ending.stop();
    EXPECT_TRUE(fs::exists(socket));
    ::close(another);
}

TEST_F(Instances, of_three_started_at_once_on_a_stale_socket_exactly_one_gets_it) {
    for (int round = 0; round < (sanitized ? 5 : 30); ++round) {    // a sanitizer makes each fork slow
        const int stale = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        socket.copy(address.sun_path, sizeof address.sun_path - 1);
        ASSERT_EQ(::bind(stale, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        ::close(stale);
        int go[2], said[2];
        ASSERT_TRUE(::pipe(go) == 0 && ::pipe(said) == 0);
        std::vector<std::unique_ptr<Child>> three;
        for (int i = 0; i < 3; ++i)
            three.push_back(std::make_unique<Child>([&] {
                ::close(go[1]);
                char none;
                Server control{io};
                static_cast<void>(::read(go[0], &none, 1));    // all at the same time
                const char has = control.start(socket).error.empty() ? 'y' : 'n';
                return ::write(said[1], &has, 1) == 1 ? ::pause() : 1;
            }));
        ::close(go[0]);
        ::close(go[1]);
        std::string words;
        char word;
        while (words.size() < 3 && ::read(said[0], &word, 1) == 1) words += word;
        EXPECT_EQ(std::count(words.begin(), words.end(), 'y'), 1) << words << " in round " << round;
        const int fd = connect_unix(socket);
        EXPECT_GE(fd, 0) << "and it is found there, round " << round;
        ::close(fd);
        ::close(said[0]);
        ::close(said[1]);
        three.clear();
        fs::remove(socket);
    }
}

}    // namespace
}    // namespace local_users_tests
