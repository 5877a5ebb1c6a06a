// The control interface over TCP, as other hosts and browsers use it.
#include <http/client/certificate.hpp>
#include <support/child.hpp>
#include <support/process.hpp>
#include <support/sanitized.hpp>
#include <support/temp_dir.hpp>
#include <sys/unique_fd.hpp>

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <vector>

namespace network_listener_tests {
namespace {

using namespace support;

const std::string looks = "view-token-0123456789", acts = "control-token-0123456789";

/// Sent through a proxy, so that a token is needed whichever user runs the test.
std::string request(const std::string& line, const std::string& headers = {}, const std::string& body = {}) {
    return line + " HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\nConnection: close\r\nContent-Length: " +
           std::to_string(body.size()) + "\r\n" + headers + "\r\n" + body;
}
std::string bearer(const std::string& token) { return "Authorization: Bearer " + token + "\r\n"; }
std::string code_of(const std::string& answer) { return answer.size() > 12 ? answer.substr(9, 3) : answer; }

class NetworkListener : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(daemon.until_answers()) << daemon.output();
        port = daemon.http_port();
        ASSERT_NE(port, 0) << daemon.output();
    }
    void TearDown() override {
        daemon.signal(SIGTERM);
        EXPECT_EQ(daemon.wait(), 0) << daemon.output();
    }

    TempDir dir;
    std::string tokens = [this] {
        const std::string file = dir.write("token", "view " + looks + "\ncontrol " + acts + "\n");
        std::filesystem::permissions(file, std::filesystem::perms{0600});
        return file;
    }();
    std::string config() {
        return dir.write(
            "anogate.json",
            R"({"links": ["udp-listen:127.0.0.1:0,name=ground"], "control": {"http": "127.0.0.1:0", "token_file": ")" + tokens +
                "\"}}");
    }
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config()}};
    std::uint16_t port = 0;
};

TEST_F(NetworkListener, accepts_only_requests_with_a_valid_token) {
    EXPECT_EQ(code_of(http(port, request("GET /status"))), "401");
    EXPECT_EQ(code_of(http(port, request("GET /status", bearer(looks)))), "200");
    EXPECT_EQ(code_of(http(port, request("GET /status", bearer(acts)))), "200");
    EXPECT_EQ(code_of(http(port, request("GET /status", bearer("wrong")))), "401");
    EXPECT_NE(http(port, request("GET /status")).find("WWW-Authenticate: Bearer"), std::string::npos);
}

TEST_F(NetworkListener, serves_only_the_page_without_a_token) {
    const std::string page = "Accept: text/html\r\nAccept-Encoding: gzip\r\n";
    EXPECT_EQ(code_of(http(port, request("GET /"))), "401") << "the list of routes";
    EXPECT_EQ(code_of(http(port, request("GET /web/none.js", page))), "404") << "which files there are is no secret";
    const std::string code = code_of(http(port, request("GET /", page)));
    EXPECT_TRUE(code == "200" || code == "401") << code << ": the page, where it was built";
    EXPECT_EQ(code_of(http(port, request("POST /", "Content-Type: application/json\r\n" + page, "{}"))), "405");
}

TEST_F(NetworkListener, the_read_only_token_allows_no_actions) {
    const std::string json = "Content-Type: application/json\r\n";
    EXPECT_EQ(code_of(http(port, request("POST /gpio", json + bearer(looks), "{}"))), "403");
    EXPECT_EQ(code_of(http(port, request("POST /gpio", json, "{}"))), "401");
    EXPECT_EQ(code_of(http(port, request("POST /gpio", json + bearer(acts), "{}"))), "404") << "there is no such line";
}

TEST_F(NetworkListener, sets_a_cookie_for_a_browser_that_signs_in_with_a_token) {
    const std::string json = "Content-Type: application/json\r\n";
    const std::string answer = http(port, request("POST /login", json, R"({"token": ")" + looks + "\"}"));
    ASSERT_EQ(code_of(answer), "200") << answer;
    EXPECT_EQ(body_of(answer), "{\"access\": \"view\"}\n");
    const auto begin = answer.find("Set-Cookie: ") + 12;
    const std::string cookie = "Cookie: " + answer.substr(begin, answer.find(';', begin) - begin) + "\r\n";
    EXPECT_EQ(code_of(http(port, request("GET /status", cookie))), "200");
    EXPECT_EQ(code_of(http(port, request("POST /login", json, R"({"token": "wrong"})"))), "401");
    for (const std::string body : {"", "{}", "[]", "{\"token\": 5}", "{\"token\""})
        EXPECT_EQ(code_of(http(port, request("POST /login", json, body))), "400") << body;
}

TEST_F(NetworkListener, rejects_other_host_names_other_origins_and_forms) {
    const auto asked = [&](const std::string& host, const std::string& more, const std::string& line = "GET /status") {
        const std::string body = line.starts_with("POST") ? "{}" : "";
        return code_of(http(port, line + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\nContent-Length: " +
                                      std::to_string(body.size()) + "\r\n" + bearer(acts) + more + "\r\n" + body));
    };
    EXPECT_EQ(asked("127.0.0.1:" + std::to_string(port), ""), "200");
    EXPECT_EQ(asked("evil.example", ""), "403");
    EXPECT_EQ(asked("localhost", "Origin: http://evil.example\r\n"), "403");
    EXPECT_EQ(asked("localhost", "Content-Type: text/plain\r\n", "POST /gpio"), "415");
}

// A browser opens them for a page of another site, with our cookies.
TEST_F(NetworkListener, streams_opened_by_pages_of_other_sites_leave_some_for_the_gateways_page) {
    const auto first_line = [&](int fd, const std::string& headers) {
        const std::string asked = request("GET /frames", bearer(acts) + headers);
        EXPECT_EQ(::send(fd, asked.data(), asked.size(), MSG_NOSIGNAL), static_cast<ssize_t>(asked.size()));
        char begin[12]{};
        EXPECT_EQ(::recv(fd, begin, sizeof begin, MSG_WAITALL), static_cast<ssize_t>(sizeof begin));
        return std::string{begin + 9, 3};
    };
    std::vector<anogate::UniqueFd> foreign;
    for (int i = 0; i < 30; ++i) {
        foreign.emplace_back(connect_tcp(port));
        first_line(foreign.back().get(), "Sec-Fetch-Site: cross-site\r\n");
    }
    const anogate::UniqueFd own{connect_tcp(port)};
    EXPECT_EQ(first_line(own.get(), "Sec-Fetch-Site: same-origin\r\n"), "200");
}

TEST_F(NetworkListener, slows_down_clients_that_guess_tokens) {
    for (int i = 0; i < 10; ++i)
        EXPECT_EQ(code_of(http(port, request("GET /status", bearer("guess" + std::to_string(i))))), "401");
    EXPECT_EQ(code_of(http(port, request("GET /status", bearer("guess")))), "429");
    EXPECT_EQ(code_of(http(port, request("GET /status", bearer(acts)))), "200") << "others may have guessed";
    EXPECT_EQ(code_of(http(dir / "control.sock", "GET /status HTTP/1.0\r\n\r\n")), "200") << "the socket is another listener";
}

TEST_F(NetworkListener, many_network_clients_leave_room_for_the_control_socket) {
    std::vector<int> crowd;
    for (int i = 0; i < 100; ++i) {
        crowd.push_back(connect_tcp(port));
        const std::string half = "GET /sta";
        if (crowd.back() >= 0) ::send(crowd.back(), half.data(), half.size(), MSG_NOSIGNAL);
    }
    for (int i = 0; i < 20; ++i) EXPECT_EQ(code_of(http(dir / "control.sock", "GET /status HTTP/1.0\r\n\r\n")), "200");
    for (const int fd : crowd) ::close(fd);
}

TEST_F(NetworkListener, ten_thousand_connections_in_turn_leak_no_descriptors_and_no_memory) {
    const auto descriptors = [&] {
        return std::distance(std::filesystem::directory_iterator{"/proc/" + std::to_string(daemon.pid()) + "/fd"}, {});
    };
    const std::string whole = request("GET /nothing", bearer(looks)), half = "GET /sta";
    ASSERT_EQ(code_of(http(port, whole)), "404");
    const auto before = descriptors();
    const long memory = daemon.proc_status("VmRSS");
    for (int i = 0; i < 10000; ++i) {
        const int fd = connect_tcp(port);
        ASSERT_GE(fd, 0) << i;
        if (i % 3 == 0) ::send(fd, half.data(), half.size(), MSG_NOSIGNAL);
        ::close(fd);
    }
    EXPECT_EQ(code_of(http(port, whole)), "404");
    EXPECT_TRUE(wait_until([&] { return descriptors() <= before; })) << descriptors() << " of " << before;
    if (!sanitized) {
        EXPECT_LT(daemon.proc_status("VmRSS"), memory + 8 * 1024);
    }
}

TEST(NetworkListenerTokens, are_created_when_there_are_none) {
    TempDir dir;
    const std::string config = dir.write(
        "anogate.json", R"({"links": ["udp-listen:127.0.0.1:0"], "control": {"http": "127.0.0.1:0", "token_file": ")" +
                            (dir / "state/token") + "\"}}");
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config}};
    ASSERT_TRUE(daemon.until_says("http://127.0.0.1:")) << daemon.output();
    EXPECT_TRUE(std::filesystem::exists(dir / "state/token"));
    EXPECT_TRUE(daemon.until_says("the tokens are in " + (dir / "state/token"))) << daemon.output();
}

TEST(NetworkListenerTokens, with_a_fault_keep_http_off_and_the_gateway_running) {
    TempDir dir;
    const std::string tokens = dir.write("token", "everything is fine\n");
    std::filesystem::permissions(tokens, std::filesystem::perms{0600});
    const std::string config = dir.write(
        "anogate.json",
        R"({"links": ["udp-listen:127.0.0.1:0"], "control": {"http": "127.0.0.1:0", "token_file": ")" + tokens + "\"}}");
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config}};
    ASSERT_TRUE(daemon.until_says("control.http stays off: control.token_file: " + tokens + ": line 1: ")) << daemon.output();
    EXPECT_TRUE(daemon.until_answers()) << daemon.output();
    EXPECT_EQ(daemon.output().find("http://127.0.0.1:"), std::string::npos) << daemon.output();
}

TEST(NetworkListenerPort, that_is_in_use_is_waited_for) {
    TempDir dir;
    const int taken = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    // Above the ports that the kernel chooses: once free, no other program gets it.
    std::uint16_t port = 61000;
    do {
        address.sin_port = htons(++port);
    } while (port < 65535 && ::bind(taken, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0);
    ASSERT_EQ(::listen(taken, 1), 0);
    const std::string where = "127.0.0.1:" + std::to_string(port);
    Daemon daemon{ANOGATED,
                  dir / "control.sock",
                  {"udp-listen:127.0.0.1:0", "--http", where},
                  {"STATE_DIRECTORY=" + dir.path().string(), "XDG_STATE_HOME=" + dir.path().string()}};
    ASSERT_TRUE(daemon.until_says("Address already in use; waiting for it")) << daemon.output();
    ASSERT_TRUE(daemon.until_answers());
    ::close(taken);
    EXPECT_TRUE(daemon.until_says("http://" + where + ": up")) << daemon.output();
}

/// With a certificate made for the test.
class EncryptedListener : public testing::Test {
protected:
    void SetUp() override {
        const auto made = anogate::http::make_certificate({{"localhost"}, {"127.0.0.1"}}, dir / "cert.pem", dir / "key.pem");
        ASSERT_TRUE(made) << made.error();
        const std::string tokens = dir.write("token", "view " + looks + "\ncontrol " + acts + "\n");
        std::filesystem::permissions(tokens, std::filesystem::perms{0600});
        const std::string config = dir.write(
            "anogate.json", R"({"links": ["udp-listen:127.0.0.1:0"], "control": {"http": "127.0.0.1:0", "token_file": ")" +
                                tokens + R"(", "tls": {"certificate": ")" + (dir / "cert.pem") + R"(", "key": ")" +
                                (dir / "key.pem") + "\"}}}");
        daemon = std::make_unique<Daemon>(ANOGATED, dir / "control.sock", std::vector<std::string>{"--config", config});
        const std::string before = "https://127.0.0.1:";
        ASSERT_TRUE(daemon->until_says(before)) << daemon->output();
        port = daemon->output().substr(daemon->output().rfind(before) + before.size());
        port = port.substr(0, port.find(':'));
    }
    /// The status code that curl receives; "000": none.
    std::string curl(const std::string& arguments) {
        Shell shell{"curl -sS -m 20 -o /dev/null -w '%{http_code}' " + arguments};
        shell.wait();
        return shell.output();
    }

    TempDir dir;
    std::unique_ptr<Daemon> daemon;
    std::string port;
};

/// `text` after its length in `bytes` bytes.
std::string sized(int bytes, const std::string& text) {
    std::string length;
    for (int i = bytes - 1; i >= 0; --i) length += static_cast<char>(text.size() >> (8 * i));
    return length + text;
}

/// The first message of a TLS 1.2 client, which the server answers with a signature (RFC 5246, 7.4.1.2).
std::string hello_of_client() {
    const std::string groups{"\0\x0A\0\x06\0\x04\0\x1D\0\x17", 10}, points{"\0\x0B\0\x02\x01\0", 6};
    const std::string signatures{"\0\x0D\0\x0A\0\x08\x04\x03\x08\x04\x04\x01\x05\x03", 14}, ciphers = "\xC0\x2F\xC0\x2B";
    const std::string hello = "\x03\x03" + std::string(32, 'r') + std::string(1, '\0') + sized(2, ciphers) +
                              std::string{"\x01\0", 2} + sized(2, groups + points + signatures);
    return "\x16\x03\x01" + sized(2, "\x01" + sized(3, hello));
}

TEST_F(EncryptedListener, is_identified_by_its_certificate) {
    const std::string mine = "--cacert " + (dir / "cert.pem") + " -H 'Authorization: Bearer " + looks + "' ";
    EXPECT_EQ(curl(mine + "https://localhost:" + port + "/status"), "200");
    EXPECT_EQ(
        curl(mine + "--tls-max 1.2 https://localhost:" + port + "/status -o /dev/null https://localhost:" + port + "/status"),
        "200200");
    EXPECT_EQ(curl("-H 'Authorization: Bearer " + looks + "' https://localhost:" + port + "/status 2> /dev/null"), "000")
        << "nobody vouches for it";
    EXPECT_EQ(curl(mine + "--tls-max 1.1 https://localhost:" + port + "/status 2> /dev/null"), "000");
    EXPECT_EQ(curl("http://localhost:" + port + "/status 2> /dev/null"), "000") << "not encrypted";
}

TEST_F(EncryptedListener, withstands_junk_and_silent_clients) {
    const auto number = static_cast<std::uint16_t>(std::stoi(port));
    std::vector<int> silent;
    for (int i = 0; i < 60; ++i) silent.push_back(connect_tcp(number));
    for (const std::string& junk :
         {std::string(5000, '\0'), std::string("GET / HTTP/1.1\r\n\r\n"), std::string("\x16\x03\x01\xFF\xFF", 5)})
        http(number, junk + std::string(100, '\xFF'));
    for (const int fd : silent) ::close(fd);
    EXPECT_EQ(curl("-k -H 'Authorization: Bearer " + looks + "' https://localhost:" + port + "/status"), "200");
    EXPECT_TRUE(daemon->until_answers());
}

// All are pending at once, as the gateway was stopped meanwhile.
TEST_F(EncryptedListener, limits_the_pending_handshakes_of_one_client) {
    const auto number = static_cast<std::uint16_t>(std::stoi(port));
    const std::string hello = hello_of_client();
    daemon->signal(SIGSTOP);
    std::vector<anogate::UniqueFd> all;
    for (int i = 0; i < 50; ++i) {
        all.emplace_back(connect_tcp(number, "127.70.0.1"));
        ASSERT_TRUE(all.back());
        ::send(all.back().get(), hello.data(), hello.size(), MSG_NOSIGNAL);
    }
    daemon->signal(SIGCONT);
    int refused = 0;
    for (const auto& one : all) {
        pollfd answered{one.get(), POLLIN, 0};
        ASSERT_EQ(::poll(&answered, 1, 20'000), 1);
        char byte = 0;
        refused += ::recv(one.get(), &byte, 1, MSG_DONTWAIT) == 1 ? 0 : 1;
    }
    EXPECT_GE(refused, 5);
    EXPECT_GE(50 - refused, 6);
    EXPECT_EQ(curl("-k -H 'Authorization: Bearer " + acts + "' https://localhost:" + port + "/status"), "200");
}

// Each hello costs the gateway a signature, and its sender nothing.
TEST_F(EncryptedListener, a_flood_of_hellos_blocks_no_client_with_the_control_token) {
    if (sanitized) GTEST_SKIP() << "with a sanitizer the gateway is ten times slower than those who flood it";
    const auto number = static_cast<std::uint16_t>(std::stoi(port));
    const std::string hello = hello_of_client();
    const auto flood = [&](int network) {
        for (int n = 0;;) {
            std::vector<anogate::UniqueFd> held;
            for (int i = 0; i < 40; ++i, ++n) {
                held.emplace_back(connect_tcp(number, "127." + std::to_string(network) + "." + std::to_string(n / 250 % 250) +
                                                          "." + std::to_string(n % 250 + 1)));
                if (held.back()) ::send(held.back().get(), hello.data(), hello.size(), MSG_NOSIGNAL);
            }
            ::usleep(10'000);
        }
        return 0;
    };
    const Child first{[&] { return flood(71); }}, second{[&] { return flood(72); }};
    const std::string asks = "-k -H 'Authorization: Bearer " + acts + "' https://localhost:" + port + "/status";
    for (int i = 0; i < 20; ++i) EXPECT_EQ(curl(asks), "200") << i;
}

/// Opens and closes connections as fast as it can, 40 at a time; `one` address, or hundreds.
int churn(std::uint16_t port, bool one, const std::string& says) {
    for (int n = 0;;) {
        std::vector<anogate::UniqueFd> held;
        for (int i = 0; i < 40; ++i, ++n) {
            const std::string many = "127.73." + std::to_string(n / 200 % 20) + "." + std::to_string(n % 200 + 1);
            held.emplace_back(connect_tcp(port, one ? "127.73.0.1" : many));
            if (held.back()) ::send(held.back().get(), says.data(), says.size(), MSG_NOSIGNAL);
        }
    }
}

/// How long `ask` takes, of ten times the longest: a SYN that is sent again costs a second.
template <class Ask>
double longest_ms(Ask ask) {
    double longest = 0;
    for (int i = 0; i < 10; ++i) {
        const auto began = std::chrono::steady_clock::now();
        ask();
        const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
        longest = std::max(longest, took.count());
        ::usleep(50'000);
    }
    return longest;
}

constexpr double hang = 10'000;    // ms; how much a flood delays a client depends on the computer: see the table of attacks

TEST_F(NetworkListener, thousands_of_new_connections_a_second_delay_no_other_client) {
    if (sanitized) GTEST_SKIP() << "with a sanitizer the gateway is ten times slower than those who flood it";
    for (const bool one : {true, false})
        for (const std::string& says : {std::string{}, std::string{"GET /status HTT"}}) {
            const Child first{[&] { return churn(port, one, says); }}, second{[&] { return churn(port, one, says); }};
            ::usleep(300'000);
            EXPECT_LT(longest_ms([&] { EXPECT_EQ(code_of(http(port, request("GET /status", bearer(acts)))), "200"); }), hang)
                << (one ? "one address, " : "many, ") << says;
        }
}

TEST_F(EncryptedListener, thousands_of_new_connections_a_second_delay_no_other_client) {
    if (sanitized) GTEST_SKIP() << "with a sanitizer the gateway is ten times slower than those who flood it";
    const auto number = static_cast<std::uint16_t>(std::stoi(port));
    const std::string asks = "-k -H 'Authorization: Bearer " + acts + "' https://localhost:" + port + "/status";
    for (const bool one : {true, false})
        for (const std::string& says : {std::string{}, hello_of_client()}) {
            const Child first{[&] { return churn(number, one, says); }}, second{[&] { return churn(number, one, says); }};
            ::usleep(300'000);
            EXPECT_LT(longest_ms([&] { EXPECT_EQ(curl(asks), "200"); }), hang)
                << (one ? "one address, " : "many, ") << says.size();
        }
}

}    // namespace
}    // namespace network_listener_tests
