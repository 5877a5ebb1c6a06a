// The memory of the program when peers join and leave.
#include <support/process.hpp>
#include <support/sanitized.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>
#include <sys/descriptor.hpp>

#include <gtest/gtest.h>

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <deque>
#include <thread>
#include <vector>

namespace memory_tests {
namespace {

using namespace support;

constexpr int places = 12;    // the default of max_peers without the places reserved for hosts that send commands
const Bytes telemetry = frame(0xDC, 0xFE, 0x03, {1, 2, 3, 4, 5, 6, 0});

// Unknown senders, each with its own port, that send once and replace another peer.
class Strangers {
public:
    explicit Strangers(const Daemon& daemon) : daemon_{daemon}, ground_{daemon.port("ground")}, air_{daemon.port("air")} {}

    // Each one is registered before the next sends, and telemetry is sent to it. The status is read now and then, so that its
    // memory lies between that of peers.
    bool come(int count) {
        for (int i = 0; i < count; ++i) {
            here_.emplace_back();
            here_.back().send(ground_, vendor::who_are_you);
            const auto send_telemetry = [&] {
                vehicle_.send(air_, telemetry), std::this_thread::sleep_for(std::chrono::milliseconds{1});
            };
            if (!wait_until([&] { return !here_.back().heard().empty(); }, patience, send_telemetry)) return false;
            if (here_.size() > places) here_.pop_front();
            if (i % places == 0) daemon_.status();
        }
        return true;
    }

private:
    const Daemon& daemon_;
    std::uint16_t ground_, air_;
    UdpPeer vehicle_;
    std::deque<UdpPeer> here_;
};

TEST(Memory, does_not_grow_when_new_peers_replace_others) {
    if (sanitized) GTEST_SKIP() << "a sanitizer keeps what is freed";
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"udp-listen:127.0.0.1:0,name=ground", "udp-listen:127.0.0.1:0,name=air"}};
    ASSERT_TRUE(daemon.until_up("ground") && daemon.until_up("air"));
    Strangers strangers{daemon};
    ASSERT_TRUE(strangers.come(2 * places));
    const long before = daemon.proc_status("RssAnon");
    ASSERT_TRUE(strangers.come(60 * places));
    const long after = daemon.proc_status("RssAnon");
    EXPECT_LT(after - before, 128) << "KB, from " << before;
    EXPECT_EQ(daemon.link("ground").at("channels").size(), std::size_t{places});
}

// When the thread of the log starts, it reserves some hundred megabytes of addresses for a moment.
bool has_started(Daemon& daemon) { return daemon.until_says("ground: up"); }

TEST(Memory, shortage_rejects_a_new_peer) {
    if (sanitized) GTEST_SKIP() << "a sanitizer needs the addresses for itself";
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("ground") && has_started(daemon));
    const std::uint16_t port = daemon.port("ground");
    const rlim_t some = 512 * 1024;    // less than a peer may need, more than an answer to a request
    const rlim_t now = static_cast<rlim_t>(daemon.proc_status("VmSize")) * 1024;
    const rlimit little{now + some, RLIM_INFINITY}, any{RLIM_INFINITY, RLIM_INFINITY};
    ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &little, nullptr), 0);
    UdpPeer stranger;
    stranger.send(port, vendor::who_are_you);
    EXPECT_TRUE(wait_until([&] { return daemon.count("ground", "denied_in") == 1; })) << daemon.output();
    EXPECT_EQ(daemon.link("ground").at("channels").size(), 0u);
    EXPECT_EQ(daemon.link("ground").at("hint"),
              "new peers were refused for lack of memory: free some, or raise the memory limit of the service");
    ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &any, nullptr), 0);
    stranger.send(port, vendor::who_are_you);
    EXPECT_TRUE(wait_until([&] { return daemon.link("ground").at("channels").size() == 1; })) << "there is memory again";
}

anogate::UniqueFd connected_to(const std::string& path) {
    anogate::UniqueFd fd{connect_unix(path)};
    EXPECT_TRUE(fd);
    return fd;
}

// Everything sent was read, or the other end has closed.
bool was_heard(int fd) {
    int waiting = 0;
    char byte;
    const bool closed = ::recv(fd, &byte, 1, MSG_DONTWAIT | MSG_PEEK) >= 0 || errno != EAGAIN;
    return closed || (::ioctl(fd, SIOCOUTQ, &waiting) == 0 && waiting == 0);
}

// Requests that arrive in pieces and are never complete use up the memory.
TEST(Memory, shortage_rejects_a_request) {
    if (sanitized) GTEST_SKIP() << "a sanitizer needs the addresses for itself";
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("ground") && has_started(daemon));
    const rlimit any{RLIM_INFINITY, RLIM_INFINITY};
    const std::string beginning = "POST /status HTTP/1.1\r\nContent-Length: 65536\r\n\r\n" + std::string(60'000, 'x');
    for (const rlim_t some : {rlim_t{0}, rlim_t{512 * 1024}, rlim_t{1024 * 1024}}) {
        const rlimit little{static_cast<rlim_t>(daemon.proc_status("VmSize")) * 1024 + some, RLIM_INFINITY};
        ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &little, nullptr), 0);
        std::vector<anogate::UniqueFd> clients;
        for (int i = 0; i < 32; ++i) {
            clients.push_back(connected_to(dir / "control"));
            ::send(clients.back().get(), beginning.data(), beginning.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        }
        EXPECT_TRUE(
            wait_until([&] { return std::ranges::all_of(clients, [](const auto& client) { return was_heard(client.get()); }); }));
        clients.clear();
        ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &any, nullptr), 0);
        ASSERT_TRUE(daemon.until_answers()) << daemon.output();
        EXPECT_EQ(daemon.count("ground", "frames_in"), 0u) << "it lives, and answers";
    }
}

// Each of these clients needs a channel, or memory for the frames that it watches.
TEST(Memory, shortage_rejects_a_web_socket) {
    if (sanitized) GTEST_SKIP() << "a sanitizer needs the addresses for itself";
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"sim:fc", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("ground") && has_started(daemon));
    const rlimit any{RLIM_INFINITY, RLIM_INFINITY};
    for (const rlim_t some : {rlim_t{400}, rlim_t{448}, rlim_t{512}, rlim_t{700}, rlim_t{1024}, rlim_t{1500}, rlim_t{2048}})
        for (const std::string path : {"link", "frames?format=binary", "frames", "foxglove", "alarms", "devices/0xDC/log"}) {
            const rlimit little{static_cast<rlim_t>(daemon.proc_status("VmSize")) * 1024 + some * 1024, RLIM_INFINITY};
            ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &little, nullptr), 0);
            std::vector<anogate::UniqueFd> clients;
            for (int i = 0; i < 16; ++i) {
                clients.push_back(connected_to(dir / "control"));
                const std::string request = "GET /" + path +
                                            " HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                                            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
                                            "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";
                ::send(clients.back().get(), request.data(), request.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
            }
            const auto is_answered = [](const auto& client) {
                char byte;
                return ::recv(client.get(), &byte, 1, MSG_DONTWAIT | MSG_PEEK) >= 0 || errno != EAGAIN;
            };
            EXPECT_TRUE(wait_until([&] { return std::ranges::all_of(clients, is_answered); })) << path << ' ' << some;
            clients.clear();
            ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &any, nullptr), 0);
            ASSERT_TRUE(daemon.until_answers()) << path << ' ' << some << daemon.output();
        }
}

TEST(Memory, shortage_is_reported_to_clients) {
    if (sanitized) GTEST_SKIP() << "a sanitizer needs the addresses for itself";
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(has_started(daemon));
    const rlim_t some = 128 * 1024;    // enough to refuse, not to answer
    const rlimit little{static_cast<rlim_t>(daemon.proc_status("VmSize")) * 1024 + some, RLIM_INFINITY};
    const rlimit any{RLIM_INFINITY, RLIM_INFINITY};
    ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &little, nullptr), 0);
    const std::string answer = http(dir / "control", "GET /status HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 503 Service Unavailable")) << answer;
    EXPECT_NE(answer.find("\r\nRetry-After: 1\r\n"), std::string::npos) << answer;
    EXPECT_EQ(body_of(answer).find("{\"error\": \"not enough memory for a request; try again\", "), 0u) << answer;
    ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &any, nullptr), 0);
    EXPECT_TRUE(daemon.until_answers()) << "there is memory again";
}

TEST(Memory, shortage_rejects_a_reload) {
    if (sanitized) GTEST_SKIP() << "a sanitizer needs the addresses for itself";
    const TempDir dir;
    const std::string one = R"("udp-listen:127.0.0.1:0,name=ground")";
    for (const rlim_t some : {0u, 16u, 64u, 300u, 1'000u, 4'000u, 20'000u}) {
        const std::string file = dir.write("anogate.json", R"({"links": [)" + one + "]}");
        Daemon daemon{ANOGATED, dir / "control", {"--config", file}};
        ASSERT_TRUE(daemon.until_up("ground") && has_started(daemon));
        std::string more = one;
        for (int i = 0; i < 30; ++i) more += R"(, "udp-listen:127.0.0.1:0,name=n)" + std::to_string(i) + '"';
        dir.write("anogate.json", R"({"links": [)" + more + "]}");
        const rlimit little{(static_cast<rlim_t>(daemon.proc_status("VmSize")) + some) * 1024, RLIM_INFINITY};
        const rlimit any{RLIM_INFINITY, RLIM_INFINITY};
        ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &little, nullptr), 0);
        daemon.signal(SIGHUP);
        EXPECT_TRUE(daemon.until_says("reload: nothing was changed: ")) << some << ' ' << daemon.output();
        ASSERT_EQ(::prlimit(daemon.pid(), RLIMIT_AS, &any, nullptr), 0);
        ASSERT_TRUE(daemon.until_answers()) << some << ' ' << daemon.output();
        EXPECT_EQ(daemon.status().at("links").size(), 1u);
        daemon.signal(SIGHUP);
        EXPECT_TRUE(daemon.until([&](const auto& status) { return status.at("links").size() == 31; })) << "there is memory again";
    }
}

// Most of each reserved buffer is never touched. A huge page would be touched as a whole, and the kernel may join pages into one
// later.
TEST(Memory, has_no_huge_pages) {
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("ground"));
    EXPECT_EQ(daemon.proc_status("THP_enabled"), 0);
}

}    // namespace
}    // namespace memory_tests
