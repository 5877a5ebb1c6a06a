// A broker of the test: mosquitto with a configuration and a port of its own, and clients of it.
#pragma once
#include <mqtt/broker.hpp>
#include <support/http.hpp>
#include <support/namespaces.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/wait.hpp>

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

/// Skips the test where the broker is not installed.
#define ANOGATE_NEEDS_MOSQUITTO() \
    if (std::system("command -v mosquitto >/dev/null") != 0) GTEST_SKIP() << "mosquitto is not installed"

namespace mqtt_tests {

using namespace std::chrono_literals;

/// A private network in which every packet to 10.9.0.2 is lost.
class NetworkThatDrops {
public:
    NetworkThatDrops() {
        net_.join(away_, "v0", "10.9.0.1/24", "10.9.0.3/24");
        net_.ip("neighbour add 10.9.0.2 lladdr 02:00:00:00:00:02 dev v0");
    }

private:
    const support::Namespace away_;
    const support::NetworkNamespace net_;
};

/// A port that is free now.
inline std::uint16_t free_port() {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ::bind(fd, reinterpret_cast<sockaddr*>(&address), size);
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    ::close(fd);
    return ntohs(address.sin_port);
}

class Mosquitto {
public:
    /// `lines`: of its configuration; without any, everybody may do everything on 127.0.0.1.
    explicit Mosquitto(const std::string& lines = "allow_anonymous true\n") {
        file_ = dir_.write("mosquitto.conf", "user root\nlistener " + std::to_string(port_) + " 127.0.0.1\n" + lines);
        start();
    }
    void start() {
        process_ = std::make_unique<support::Process>("mosquitto", std::vector<std::string>{"-c", file_});
        EXPECT_TRUE(support::wait_until([&] {
            const int fd = support::connect_tcp(port_);
            if (fd >= 0) ::close(fd);
            return fd >= 0;
        })) << process_->output();
    }
    void kill() {
        process_->signal(SIGKILL);
        process_->wait();
    }
    void reload() { process_->signal(SIGHUP); }
    std::uint16_t port() const { return port_; }
    std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
    support::Process& process() { return *process_; }
    const support::TempDir& dir() const { return dir_; }

private:
    support::TempDir dir_;
    std::uint16_t port_ = free_port();
    std::string file_;
    std::unique_ptr<support::Process> process_;
};

struct Answer {
    std::uint64_t id = 0;
    std::uint8_t reason = 0;
    bool operator==(const Answer&) const = default;
};

/// A client of a broker, which keeps everything that happens.
class Client {
    template <class Call>
    auto with(Call call) {
        const std::lock_guard lock{mutex_};
        return call();
    }

public:
    explicit Client(anogate::BrokerSettings settings)
        : broker_{
              std::move(settings),
              {.will = [](std::uint64_t connection) { return "will " + std::to_string(connection); },
               .connected =
                   [this](std::uint64_t connection, std::size_t window) {
                       with([&] { connections_ = connection, window_ = window, is_connected_ = true; });
                   },
               .disconnected = [this](const std::string& why) { with([&] { faults_.push_back(why), is_connected_ = false; }); },
               .answered = [this](std::uint64_t id, std::uint8_t reason) { with([&] {
                                                                               answers_.push_back({id, reason});
                                                                           }); },
               .received = [this](anogate::BrokerMessage message) { with([&] { messages_.push_back(std::move(message)); }); }}} {
        broker_.start();
    }
    Client(std::uint16_t port, const std::string& id, std::vector<anogate::Subscription> subscriptions = {})
        : Client{settings_of(port, id, std::move(subscriptions))} {
        EXPECT_TRUE(until_connected());
    }
    ~Client() { broker_.stop(support::patience); }

    static anogate::BrokerSettings settings_of(std::uint16_t port, const std::string& id,
                                               std::vector<anogate::Subscription> subscriptions = {}) {
        anogate::BrokerSettings settings;
        settings.host = "127.0.0.1";
        settings.port = port;
        settings.client_id = id;
        settings.subscriptions = std::move(subscriptions);
        return settings;
    }

    anogate::Broker& broker() { return broker_; }
    bool until(const std::function<bool()>& holds, std::chrono::steady_clock::duration limit = support::patience) {
        return support::wait_until([&] { return with(holds); }, limit);
    }
    bool until_connected(std::uint64_t connections = 1) {
        return until([&] { return connections_ >= connections && is_connected_; });
    }
    bool until_messages(std::size_t count) {
        return until([&] { return messages_.size() >= count; });
    }
    bool until_answers(std::size_t count) {
        return until([&] { return answers_.size() >= count; });
    }
    std::vector<anogate::BrokerMessage> messages() {
        return with([&] { return messages_; });
    }
    /// The payloads received on a topic.
    std::vector<std::string> payloads(const std::string& topic) {
        std::vector<std::string> all;
        for (const auto& message : messages())
            if (message.topic == topic) all.push_back(message.payload);
        return all;
    }
    std::vector<Answer> answers() {
        return with([&] { return answers_; });
    }
    std::vector<std::string> faults() {
        return with([&] { return faults_; });
    }
    std::size_t window() {
        return with([&] { return window_; });
    }

private:
    std::mutex mutex_;
    std::uint64_t connections_ = 0;
    std::size_t window_ = 0;
    bool is_connected_ = false;
    std::vector<std::string> faults_;
    std::vector<Answer> answers_;
    std::vector<anogate::BrokerMessage> messages_;
    anogate::Broker broker_;
};

/// Certificates: an authority, and one for each of `names`, which are valid for `days`.
class Certificates {
public:
    explicit Certificates(const support::TempDir& dir) : dir_{dir} {
        run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 30 -subj /CN=authority -keyout ca.key "
            "-out ca.crt");
    }
    void issue(const std::string& name, int days = 30) {
        run("openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=" + name + " -keyout " + name +
            ".key -out " + name + ".csr && printf 'subjectAltName=DNS:localhost,IP:127.0.0.1' >" + name +
            ".ext && openssl x509 -req -in " + name + ".csr -CA ca.crt -CAkey ca.key -CAcreateserial -days " +
            std::to_string(days) + " -extfile " + name + ".ext -out " + name + ".new && mv " + name + ".new " + name + ".crt");
    }
    std::string operator/(const std::string& name) const { return dir_ / name; }

private:
    void run(const std::string& command) {
        EXPECT_EQ(support::run("cd " + dir_.path().string() + " && (" + command +
                               ") >/dev/null 2>openssl.log || (cat openssl.log; exit 1)"),
                  0);
    }
    const support::TempDir& dir_;
};

}    // namespace mqtt_tests
