// A gateway whose control interface is open to the network with two tokens, and requests to it.
#pragma once
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace support {

inline const std::string view_token = "view-token-0123456789", control_token = "control-token-0123456789";

class TokenGateway : public testing::Test {
protected:
    /// `links`: as in the configuration, "\"sim:fc\"".
    explicit TokenGateway(const std::string& links = R"("udp-listen:127.0.0.1:0,name=ground")")
        : tokens{dir.write("token", "view " + view_token + "\ncontrol " + control_token + "\n")},
          config{dir.write("anogate.json", R"({"links": [)" + links + R"(], "control": {"http": "127.0.0.1:0", "token_file": ")" +
                                               tokens + "\"}}")},
          daemon{ANOGATED, socket, {"--config", config}} {
        std::filesystem::permissions(tokens, std::filesystem::perms{0600});
    }
    void SetUp() override {
        ASSERT_TRUE(daemon.until_answers()) << daemon.output();
        port = daemon.http_port();
        ASSERT_NE(port, 0) << daemon.output();
    }

    /// A request that seems to be forwarded by a proxy, so that a token is needed, whichever user runs the test.
    static std::string request(const std::string& line, const std::string& headers = {}, const std::string& body = {}) {
        return line + " HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\nConnection: close\r\nContent-Length: " +
               std::to_string(body.size()) + "\r\n" + (body.empty() ? "" : "Content-Type: application/json\r\n") + headers +
               "\r\n" + body;
    }
    static std::string bearer(const std::string& token) { return "Authorization: Bearer " + token + "\r\n"; }
    static std::string code_of(const std::string& answer) { return answer.size() > 12 ? answer.substr(9, 3) : answer; }
    std::string code(const std::string& line, const std::string& headers = {}, const std::string& body = {}) {
        return code_of(http(port, request(line, headers, body)));
    }
    std::string code_at_socket(const std::string& line, const std::string& headers = {}, const std::string& body = {}) {
        const std::string text = line + " HTTP/1.0\r\nHost: x\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" +
                                 headers + "\r\n" + body;
        return code_of(http(socket, text));
    }

    TempDir dir;
    std::string tokens;
    std::string socket = dir / "control.sock";
    std::string config;
    Daemon daemon;
    std::uint16_t port = 0;
};

}    // namespace support
