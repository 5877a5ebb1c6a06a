// Who shares the machine with the gateway: greedy and idle clients of the control socket, other users' clients, folders that belong to
// others. tests/README.md has the figures.
#include <daemon/control.hpp>
#include <support/child.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Control;
namespace fs = std::filesystem;

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
        closed_ = closed_ || n == 0 || (errno != EAGAIN && errno != EINTR);
        return heard_;
    }
    std::size_t answers() {
        std::size_t count = 0;
        for (std::size_t at = 0; (at = heard().find("HTTP/1.1 200 OK", at)) != std::string::npos; ++at) ++count;
        return count;
    }
    bool is_closed() { return heard(), closed_; }

private:
    anogate::UniqueFd fd_;
    std::string heard_;
    bool closed_ = false;
};

/// A gateway with its control socket, in the test's own thread.
class LocalUsers : public testing::Test {
protected:
    void SetUp() override {
        control.get("/status", [this] { return on_request(), anogate::status_json(gateway.gateway()); });
        ASSERT_EQ(control.start(socket).error, "");
    }
    void TearDown() override { control.stop(); }
    std::unique_ptr<Client> connect() { return std::make_unique<Client>(socket); }

    TempDir dir;
    std::string socket = dir / "control.sock";
    RunningGateway gateway{udp_listen("ground")};
    Control control{gateway.io()};
    std::function<void()> on_request = [] {};
};

/// With every request a command is sent; how many of those of earlier requests had not arrived when the next was answered.
class GreedyClients : public LocalUsers {
protected:
    void SetUp() override {
        LocalUsers::SetUp();
        pilot.send(gateway.port("ground"), frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
        fc.send(gateway.port("ground"), frame(0xDC, 0xFE, 0xF1, {0}));
        ASSERT_TRUE(gateway.until([&] { return gateway.link("ground").at("channels").size() == 2; }));
        fc.forget();
        on_request = [this] {
            most_behind = std::max(most_behind, sent - arrived());
            const auto low = static_cast<std::uint8_t>(sent), high = static_cast<std::uint8_t>(sent >> 8);
            pilot.send(gateway.port("ground"), frame(0xFE, 0xDC, 0xC0, {16, high, low}));
            ++sent;
        };
    }
    std::size_t arrived() { return fc.heard().size() / frame(0xFE, 0xDC, 0xC0, {16, 0, 0}).size(); }
    void serve(std::size_t clients, int requests) {
        std::vector<std::unique_ptr<Client>> greedy;
        for (std::size_t i = 0; i < clients; ++i) {
            greedy.push_back(connect());
            ASSERT_TRUE(greedy.back()->ask(requests));
        }
        EXPECT_TRUE(gateway.until([&] {
            for (auto& client : greedy) client->heard();
            return sent == clients * static_cast<std::size_t>(requests);
        })) << sent;
        for (auto& client : greedy)
            EXPECT_TRUE(gateway.until([&] { return client->answers() == static_cast<std::size_t>(requests); })) << client->answers();
        EXPECT_TRUE(gateway.until([&] { return arrived() == sent; })) << arrived();
    }

    UdpPeer pilot, fc;
    std::size_t sent = 0;
    std::size_t most_behind = 0;
};

TEST_F(GreedyClients, one_with_200_requests_lets_every_command_pass_between_them) {
    serve(1, 200);
    EXPECT_LE(most_behind, 1u);
}

TEST_F(GreedyClients, sixteen_with_20_requests_each_let_every_command_pass_between_them) {
    serve(16, 20);
    EXPECT_LE(most_behind, 1u);
}

}    // namespace
