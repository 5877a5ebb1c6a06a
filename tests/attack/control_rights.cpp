// Viewers and large numbers of clients delay and refuse no command, and take no place of another client.
#include <support/child.hpp>
#include <support/pty_device.hpp>
#include <support/sanitized.hpp>
#include <support/token_gateway.hpp>
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

namespace control_rights_tests {
namespace {

using namespace support;

/// Clients that send, and read only what they must not leave unread.
class Crowd {
public:
    void add(int fd, const std::string& request) {
        if (fd < 0) return;
        ::fcntl(fd, F_SETFL, O_NONBLOCK);
        ::send(fd, request.data(), request.size(), MSG_NOSIGNAL);
        all_.emplace_back(fd);
    }
    /// The number of clients that were answered or rejected.
    std::size_t answered() const {
        return static_cast<std::size_t>(std::count_if(all_.begin(), all_.end(), [](const anogate::UniqueFd& fd) {
            pollfd look{fd.get(), POLLIN, 0};
            return ::poll(&look, 1, 0) == 1;
        }));
    }
    std::size_t size() const { return all_.size(); }

private:
    std::vector<anogate::UniqueFd> all_;
};

const std::string upgrade =
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
    "dGhlIHNhbXBsZSBub25jZQ==\r\n";

class ControlRights : public TokenGateway {
protected:
    ControlRights() : TokenGateway{R"("sim:fc")"} {}

    /// Sends a command 20 times over the network and 20 times over the socket; returns the codes that are not "200".
    std::vector<std::string> refused_commands() {
        std::vector<std::string> refused;
        for (int i = 0; i < 20; ++i)
            for (const bool at_socket : {false, true}) {
                const std::string line = "POST /devices/0xDC/commands/" + command, json = "Content-Type: application/json\r\n";
                const std::string code = at_socket ? code_at_socket(line, json, "{}")
                                                   : this->code(line, bearer(control_token), "{}");
                if (code != "200") refused.push_back(code);
            }
        return refused;
    }
    std::string command = "LAND";
};

// The device that they read answers nothing, so that each of them waits.
TEST_F(ControlRights, viewers_that_read_parameters_block_no_command) {
    Crowd viewers;
    for (int i = 0; i < 22; ++i) {
        std::string many;
        for (int n = 0; n < 30; ++n)
            many += "GET /devices/0x3" + std::to_string(n % 10) + "/parameters/" + std::to_string(i) +
                    " HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\n" + bearer(view_token) + "\r\n";
        viewers.add(connect_tcp(port), many);
    }
    const auto jobs = [&] {
        return nlohmann::json::parse(body_of(http(socket, "GET /jobs HTTP/1.0\r\n\r\n"))).at("jobs").size();
    };
    ASSERT_TRUE(wait_until([&] { return jobs() >= 4; }));
    EXPECT_EQ(refused_commands(), std::vector<std::string>{}) << command;
}

// An upgrade or a calibration; does not wait for its end.
TEST_F(ControlRights, viewers_and_pages_of_other_sites_cannot_cancel_a_job_by_disconnecting) {
    const std::string begin = R"({"what": "accelerometer"})", lines = "Accept: application/x-ndjson\r\n";
    ASSERT_EQ(code("POST /devices/0xDC/calibration", bearer(control_token), begin), "202");
    const auto state = [&] {
        return nlohmann::json::parse(body_of(http(socket, "GET /jobs/1 HTTP/1.0\r\n\r\n"))).at("state").get<std::string>();
    };
    const auto watch_and_leave = [&](const std::string& headers) {
        Crowd watcher;
        watcher.add(connect_tcp(port), request("GET /jobs/1?while_connected", lines + headers));
        ASSERT_TRUE(wait_until([&] { return watcher.answered() == 1; }));
    };
    for (int i = 0; i < 3; ++i) {
        watch_and_leave(bearer(view_token));
        watch_and_leave(bearer(control_token) + "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: no-cors\r\n");
        watch_and_leave(bearer(control_token) + "Sec-Fetch-Site: same-site\r\n");
    }
    EXPECT_EQ(code("GET /status", bearer(view_token)), "200");
    EXPECT_FALSE(wait_until([&] { return state() == "cancelled"; }, std::chrono::milliseconds{300}));
    watch_and_leave(bearer(control_token));
    EXPECT_TRUE(wait_until([&] { return state() == "cancelled"; })) << "who controls may";
}

TEST_F(ControlRights, thirty_two_web_sockets_of_one_user_leave_room_for_status_reload_and_commands) {
    Crowd sockets;
    for (int i = 0; i < 50; ++i) {
        sockets.add(connect_unix(socket), "GET /frames HTTP/1.1\r\nHost: x\r\n" + upgrade + "\r\n");
        sockets.add(connect_tcp(port),
                    "GET /frames HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\n" + bearer(view_token) + upgrade + "\r\n");
    }
    ASSERT_TRUE(wait_until([&] { return sockets.answered() == sockets.size(); }, std::chrono::minutes{1}));
    for (int i = 0; i < 20; ++i) {
        EXPECT_EQ(code_at_socket("GET /status"), "200");
        EXPECT_EQ(code_at_socket("POST /reload"), "200");
    }
    Crowd lines;
    for (int i = 0; i < 50; ++i) lines.add(connect_unix(socket), "GET /frames HTTP/1.1\r\nHost: x\r\n\r\n");
    ASSERT_TRUE(wait_until([&] { return lines.answered() == lines.size(); }, std::chrono::minutes{1}));
    Crowd readers;    // some wait for the device before the next ones ask
    for (int i = 0; i < 50; ++i)
        readers.add(connect_unix(socket), "GET /devices/0x33/parameters/" + std::to_string(i) + " HTTP/1.1\r\nHost: x\r\n\r\n");
    for (int i = 0; i < 20; ++i) {
        EXPECT_EQ(code_at_socket("GET /status"), "200");
        EXPECT_EQ(code_at_socket("POST /reload"), "200");
    }
    EXPECT_EQ(code("GET /status", bearer(control_token)), "200");
}

/// A client that connects with 70 requests at once, again and again, and does not read the answers. `connect` makes the n-th
/// connection.
class Bursts {
public:
    Bursts(std::function<int(int n)> connect, std::string request)
        : child_{[connect = std::move(connect), request = std::move(request)]() -> int {
              for (int n = 0;;) {
                  Crowd crowd;
                  for (int i = 0; i < 70; ++i) crowd.add(connect(n++), request);
                  ::usleep(20'000);
              }
          }} {}

private:
    Child child_;
};

TEST_F(ControlRights, bursts_of_whole_requests_from_thousands_of_addresses_block_no_command) {
    if (sanitized) GTEST_SKIP() << "with a sanitizer the gateway is ten times slower than those who flood it";
    std::string many;
    for (int i = 0; i < 10; ++i)
        many += "GET /nothing HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\n" + bearer(view_token) + "\r\n";
    const auto from = [this](int n) {
        return connect_tcp(port, "127.77." + std::to_string(n / 250 % 20) + "." + std::to_string(n % 250 + 1));
    };
    const Bursts first{from, many}, second{from, many};
    EXPECT_EQ(refused_commands(), std::vector<std::string>{});
}

TEST_F(ControlRights, request_bursts_of_one_user_at_the_socket_block_neither_status_nor_reload_nor_commands) {
    for (const std::string line : {"GET /metrics", "GET /status"}) {
        const auto at_socket = [this](int) { return connect_unix(socket); };
        const std::string asks = line + " HTTP/1.1\r\nHost: x\r\n\r\n";
        const Bursts first{at_socket, asks}, second{at_socket, asks};
        EXPECT_EQ(refused_commands(), std::vector<std::string>{}) << line;
        for (int i = 0; i < 20; ++i) {
            EXPECT_EQ(code_at_socket("GET /status"), "200") << line;
            EXPECT_EQ(code_at_socket("POST /reload"), "200") << line;
        }
    }
}

TEST_F(ControlRights, clients_that_exhaust_the_quota_of_one_user_leave_room_for_status_and_reload) {
    Crowd readers;    // more than the sockets can store; nothing is read
    std::string many;
    for (int i = 0; i < 50; ++i) many += "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n";
    for (int i = 0; i < 60; ++i) readers.add(connect_unix(socket), many);
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(code_at_socket("GET /status"), "200");
        EXPECT_EQ(code_at_socket("POST /reload"), "200");
    }
}

// So few that the links have used all of those reserved for them.
TEST(FewDescriptors, are_partly_reserved_for_status_and_reload) {
    constexpr int ports = 6;
    TempDir dir;
    std::vector<std::string> arguments{"udp-listen:127.0.0.1:0"};
    for (int i = 0; i < ports; ++i) arguments.push_back("pty:" + (dir / ("port" + std::to_string(i))));
    Daemon daemon{ANOGATED, dir / "control.sock", arguments, {}, [] {
                      const rlimit few{48, 48};
                      ::setrlimit(RLIMIT_NOFILE, &few);
                  }};
    const std::string socket = dir / "control.sock";
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    const auto at_socket = [&](int) { return connect_unix(socket); };
    const Bursts sockets{at_socket, "GET /frames HTTP/1.1\r\nHost: x\r\n" + upgrade + "\r\n"},
        streams{at_socket, "GET /frames HTTP/1.1\r\nHost: x\r\n\r\n"}, halves{at_socket, "GET /sta"};
    for (int i = 0; i < 20; ++i) {
        EXPECT_TRUE(http(socket, "GET /status HTTP/1.0\r\n\r\n", patience).starts_with("HTTP/1.0 200")) << i;
        const std::string reload = http(socket, "POST /reload HTTP/1.0\r\nContent-Length: 0\r\n\r\n", patience);
        EXPECT_TRUE(reload.starts_with("HTTP/1.0 200")) << i << ": " << reload;
    }
}

TEST(FewDescriptors, are_not_all_used_for_the_peers_of_a_tcp_port) {
    TempDir dir;
    Daemon daemon{ANOGATED, dir / "control.sock", {"tcp-listen:127.0.0.1:0,name=tcp,max_peers=60"}, {}, [] {
                      const rlimit few{48, 48};
                      ::setrlimit(RLIMIT_NOFILE, &few);
                  }};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    const std::uint16_t port = daemon.port("tcp");
    Crowd peers;
    for (int i = 0; i < 60; ++i) peers.add(connect_tcp(port), {});
    for (int i = 0; i < 10; ++i) {
        EXPECT_TRUE(http(dir / "control.sock", "GET /status HTTP/1.0\r\n\r\n", patience).starts_with("HTTP/1.0 200")) << i;
        const std::string reload = http(dir / "control.sock", "POST /reload HTTP/1.0\r\nContent-Length: 0\r\n\r\n", patience);
        EXPECT_TRUE(reload.starts_with("HTTP/1.0 200")) << i << ": " << reload;
    }
}

// The peers and the clients come first, so that only the reserved descriptors are left.
TEST(FewDescriptors, all_used_by_peers_and_clients_leave_those_of_status_and_reload_and_the_page_stays_on) {
    TempDir dir;
    const std::string places = "max_peers=60,max_per_address=60";
    const std::string config = dir.write("anogate.json", R"({"control": {"http": "127.0.0.1:0", "token_file": ")" +
                                                             dir / "token" + R"("}, "links": ["tcp-listen:127.0.0.1:0,name=a,)" +
                                                             places + R"(", "tcp-listen:127.0.0.1:0,name=b,)" + places +
                                                             R"(", "tcp-listen:127.0.0.1:0,name=c,)" + places + R"("]})");
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config}, {}, [] {
                      const rlimit few{40, 40};
                      ::setrlimit(RLIMIT_NOFILE, &few);
                  }};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    const Bytes command = frame(0xFE, 0xDC, 0xC0, {16, 1, 0});
    Crowd peers, sockets;
    for (const std::string link : {"a", "b", "c"})
        for (int i = 0; i < 60; ++i) peers.add(connect_tcp(daemon.port(link)), {command.begin(), command.end()});
    ASSERT_TRUE(daemon.until([](const nlohmann::json& status) {
        return status.is_object() && status.at("links").at(0).at("channels").size() >= 4;
    })) << daemon.status()["links"];
    for (int i = 0; i < 60; ++i)
        sockets.add(connect_unix(dir / "control.sock"), "GET /frames HTTP/1.1\r\nHost: x\r\n" + upgrade + "\r\n");
    for (int i = 0; i < 20; ++i) {
        EXPECT_TRUE(http(dir / "control.sock", "GET /status HTTP/1.0\r\n\r\n", patience).starts_with("HTTP/1.0 200")) << i;
        const std::string reload = http(dir / "control.sock", "POST /reload HTTP/1.0\r\nContent-Length: 0\r\n\r\n", patience);
        EXPECT_TRUE(reload.starts_with("HTTP/1.0 200")) << i << ": " << reload;
        EXPECT_EQ(reload.find("http_error"), reload.npos) << reload;
    }
    EXPECT_EQ(daemon.status()["http"]["state"], "up") << daemon.output();
}

// Those of a tcp-listen link are taken first, then those of new links, and more links wait.
TEST(FewDescriptors, used_up_by_peers_and_new_links_leave_those_of_status_and_reload) {
    TempDir dir;
    const auto config = [&](int ports) {
        std::string links = R"("tcp-listen:127.0.0.1:0,name=tcp,max_peers=60,max_per_address=60")";
        for (int i = 0; i < ports; ++i) links += ", \"pty:" + (dir / ("port" + std::to_string(i))) + "\"";
        return dir.write("anogate.json", R"({"control": {"http": "127.0.0.1:0", "token_file": ")" + dir / "token" +
                                             R"("}, "links": [)" + links + "]}");
    };
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config(0)}, {}, [] {
                      const rlimit few{48, 48};
                      ::setrlimit(RLIMIT_NOFILE, &few);
                  }};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    const Bytes command = frame(0xFE, 0xDC, 0xC0, {16, 1, 0});
    Crowd peers;
    for (int i = 0; i < 60; ++i) peers.add(connect_tcp(daemon.port("tcp")), {command.begin(), command.end()});
    ASSERT_TRUE(wait_until([&] { return peers.answered() >= 10; }));
    const auto asks = [&](const std::string& line) {
        return http(dir / "control.sock", line + " HTTP/1.0\r\nContent-Length: 0\r\n\r\n", patience);
    };
    for (const int ports : {2, 16, 16, 0}) {
        config(ports);
        for (int i = 0; i < 5; ++i) {
            const std::string reload = asks("POST /reload");
            EXPECT_TRUE(reload.starts_with("HTTP/1.0 200")) << ports << ": " << reload;
            EXPECT_EQ(reload.find("http_error"), reload.npos) << ports << ": " << reload;
            EXPECT_TRUE(asks("GET /status").starts_with("HTTP/1.0 200")) << ports;
        }
        if (ports == 2) {
            EXPECT_TRUE(daemon.until([](const nlohmann::json& status) {
                return status.is_object() && status.at("links").at(2).at("error_id") == "nobody_there";
            })) << daemon.status()["links"];
        }
    }
}

TEST(FewDescriptors, are_used_for_tcp_peers_before_clients_of_the_control_interface) {
    constexpr std::size_t hosts = 16;
    const Bytes command = frame(0xFE, 0xDC, 0xC0, {16, 1, 0});
    for (const rlim_t limit : {52u, 56u, 60u}) {
        TempDir dir;
        Daemon daemon{ANOGATED, dir / "control.sock", {"tcp-listen:127.0.0.1:0,name=tcp"}, {}, [limit] {
                          const rlimit few{limit, limit};
                          ::setrlimit(RLIMIT_NOFILE, &few);
                      }};
        ASSERT_TRUE(daemon.until_answers()) << daemon.output();
        const auto at_socket = [&] { return connect_unix(dir / "control.sock"); };
        Crowd clients, peers;
        for (int i = 0; i < 60; ++i) clients.add(at_socket(), "GET /frames HTTP/1.1\r\nHost: x\r\n" + upgrade + "\r\n");
        ASSERT_TRUE(wait_until([&] { return clients.answered() == clients.size(); }, std::chrono::minutes{1}));
        for (std::size_t i = 0; i < hosts; ++i) peers.add(connect_tcp(daemon.port("tcp")), {command.begin(), command.end()});
        // Each command is forwarded to the hosts before it. A request would make clients leave.
        EXPECT_TRUE(wait_until([&] { return peers.answered() >= hosts - 1; }, std::chrono::seconds{15}))
            << limit << ": " << peers.answered();
        for (int i = 0; i < 10; ++i)
            EXPECT_TRUE(http(dir / "control.sock", "GET /status HTTP/1.0\r\n\r\n", patience).starts_with("HTTP/1.0 200")) << i;
    }
}

// The ports of the links appear when all clients are connected.
TEST(FewDescriptors, are_used_for_links_first) {
    constexpr int ports = 8;
    TempDir dir;
    std::vector<std::string> arguments;
    for (int i = 0; i < ports; ++i) arguments.push_back("serial:" + (dir / ("port" + std::to_string(i))) + ",baud=115200");
    Daemon daemon{ANOGATED, dir / "control.sock", arguments, {}, [] {
                      const rlimit few{48, 48};
                      ::setrlimit(RLIMIT_NOFILE, &few);
                  }};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    Crowd sockets;
    for (int i = 0; i < 100; ++i)
        sockets.add(connect_unix(dir / "control.sock"), "GET /frames HTTP/1.1\r\nHost: x\r\n" + upgrade + "\r\n");
    std::vector<std::unique_ptr<PtyDevice>> devices;
    for (int i = 0; i < ports; ++i) devices.push_back(std::make_unique<PtyDevice>(dir / ("port" + std::to_string(i))));
    EXPECT_TRUE(daemon.until([](const nlohmann::json& status) {
        if (!status.is_object()) return false;
        return std::all_of(status.at("links").begin(), status.at("links").end(),
                           [](const auto& link) { return link.at("state") == "up"; });
    })) << daemon.status()["links"];
    // The final responses to rejected clients use descriptors for at most a second.
    const auto status = [&] {
        return http(dir / "control.sock", "GET /status HTTP/1.0\r\n\r\n", patience).starts_with("HTTP/1.0 200");
    };
    ASSERT_TRUE(wait_until(status));
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(status()) << i;
}

}    // namespace
}    // namespace control_rights_tests
