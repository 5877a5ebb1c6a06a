// A fleet of simulated gateways on one broker, in one process: fleet GATEWAYS RATE SECONDS. Starts a mosquitto of its own on 127.0.0.1, and
// prints what it and the clients need. tools/fleet runs it.
#include <mqtt/reconnection.hpp>

#include <mosquitto.h>
#include <mqtt_protocol.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::uint64_t now_ns() { return static_cast<std::uint64_t>(Clock::now().time_since_epoch().count()); }

class Broker {
public:
    explicit Broker(std::uint16_t port) : port_{port} {
        std::ofstream{file_} << "user root\nlistener " << port << " 127.0.0.1\nallow_anonymous true\n";
        start();
    }
    ~Broker() {
        stop();
        std::remove(file_.c_str());
    }
    void start() {
        pid_ = ::fork();
        if (pid_ == 0) {
            std::freopen("/dev/null", "w", stderr);
            ::execlp("mosquitto", "mosquitto", "-c", file_.c_str(), nullptr);
            ::_exit(127);
        }
    }
    void stop() {
        ::kill(pid_, SIGTERM);
        ::waitpid(pid_, nullptr, 0);
    }
    double cpu_seconds() const {
        std::ifstream file{"/proc/" + std::to_string(pid_) + "/stat"};
        std::string text;
        std::getline(file, text);
        std::istringstream fields{text.substr(text.rfind(')') + 1)};
        std::vector<std::string> all(13);
        for (std::string& one : all) fields >> one;
        return (std::stod(all[11]) + std::stod(all[12])) / static_cast<double>(::sysconf(_SC_CLK_TCK));
    }
    double resident_mb() const {
        std::ifstream file{"/proc/" + std::to_string(pid_) + "/statm"};
        long size = 0, resident = 0;
        file >> size >> resident;
        return static_cast<double>(resident * ::sysconf(_SC_PAGESIZE)) / (1 << 20);
    }

private:
    std::uint16_t port_;
    std::string file_ = "/tmp/anogate-fleet-" + std::to_string(::getpid()) + ".conf";
    pid_t pid_ = -1;
};

struct Totals {
    std::uint64_t sent = 0, acknowledged = 0;
    std::vector<double> latencies;    // ms, at the reader
};

class Client {
public:
    Client(const std::string& id, Totals& totals, bool is_reader)
        : totals_{totals},
          is_reader_{is_reader},
          topic_{"anogate/v1/" + id + "/up/fc-05/euler"},
          client_{mosquitto_new(id.c_str(), true, this)} {
        mosquitto_int_option(client_, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
        mosquitto_connect_v5_callback_set(client_,
                                          [](mosquitto* client, void* object, int reason, int, const mosquitto_property*) {
                                              auto& self = *static_cast<Client*>(object);
                                              self.is_connected_ = self.was_connected_ = reason == 0;
                                              if (self.is_reader_) mosquitto_subscribe(client, nullptr, "anogate/v1/+/up/+/+", 1);
                                          });
        mosquitto_disconnect_v5_callback_set(client_, [](mosquitto*, void* object, int, const mosquitto_property*) {
            auto& self = *static_cast<Client*>(object);
            self.is_connected_ = false;
            self.retry_at_ = Clock::now() + anogate::reconnect_pause({}, static_cast<double>(now_ns() % 1000) / 1000);
        });
        mosquitto_publish_v5_callback_set(client_, [](mosquitto*, void* object, int, int, const mosquitto_property*) {
            ++static_cast<Client*>(object)->totals_.acknowledged;
        });
        mosquitto_message_v5_callback_set(
            client_, [](mosquitto*, void* object, const mosquitto_message* message, const mosquitto_property*) {
                const std::uint64_t then = std::strtoull(static_cast<const char*>(message->payload), nullptr, 10);
                static_cast<Client*>(object)->totals_.latencies.push_back(static_cast<double>(now_ns() - then) / 1e6);
            });
    }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    ~Client() { mosquitto_destroy(client_); }

    bool is_connected() const { return is_connected_; }
    pollfd wanted() const {
        return {mosquitto_socket(client_), static_cast<short>(mosquitto_want_write(client_) ? POLLIN | POLLOUT : POLLIN), 0};
    }
    void step(short events, std::uint16_t port, Clock::time_point now, double random) {
        if (mosquitto_socket(client_) < 0 && now >= retry_at_) {
            if (std::exchange(was_connected_, false)) lost_at_ = now;
            retry_at_ = now + anogate::reconnect_pause(now - lost_at_, random);
            mosquitto_connect(client_, "127.0.0.1", port, 60);
        }
        if ((events & ~POLLOUT) != 0) mosquitto_loop_read(client_, 100);
        if ((events & POLLOUT) != 0) mosquitto_loop_write(client_, 1);
        mosquitto_loop_misc(client_);
    }
    void publish_at(double rate, Clock::time_point begin, Clock::time_point now, double phase) {
        const double due = std::chrono::duration<double>(now - begin).count() * rate + phase;
        while (is_connected_ && static_cast<double>(sent_) < due - 1) {
            ++sent_;
            ++totals_.sent;
            std::string payload = std::to_string(now_ns());
            payload.resize(203, ' ');    // as a record has
            mosquitto_publish(client_, nullptr, topic_.c_str(), static_cast<int>(payload.size()), payload.data(), 1, false);
        }
    }

private:
    Totals& totals_;
    bool is_reader_, is_connected_ = false;
    std::string topic_;
    mosquitto* client_;
    bool was_connected_ = true;
    Clock::time_point lost_at_{}, retry_at_{};
    std::uint64_t sent_ = 0;
};

class Fleet {
public:
    Fleet(std::size_t gateways, double rate, std::uint16_t port) : rate_{rate}, port_{port} {
        clients_.push_back(std::make_unique<Client>("reader", totals, true));
        for (std::size_t i = 0; i < gateways; ++i)
            clients_.push_back(std::make_unique<Client>("drone-" + std::to_string(i), totals, false));
    }
    std::size_t connected() const {
        return static_cast<std::size_t>(
            std::count_if(clients_.begin(), clients_.end(), [](const auto& one) { return one->is_connected(); }));
    }
    std::size_t size() const { return clients_.size(); }
    void step(bool publishes) {
        fds_.clear();
        for (const auto& client : clients_) fds_.push_back(client->wanted());
        ::poll(fds_.data(), fds_.size(), 5);
        const auto now = Clock::now();
        for (std::size_t i = 0; i < clients_.size(); ++i) {
            clients_[i]->step(fds_[i].revents, port_, now, std::uniform_real_distribution<>{}(random_));
            if (publishes && i > 0)
                clients_[i]->publish_at(rate_, begin, now, static_cast<double>(i) / static_cast<double>(clients_.size()));
        }
    }
    /// Until all are connected, at most `limit`; the seconds.
    double until_connected(Clock::duration limit) {
        const auto since = Clock::now();
        while (connected() < size() && Clock::now() - since < limit) step(false);
        return std::chrono::duration<double>(Clock::now() - since).count();
    }

    Totals totals{};
    Clock::time_point begin = Clock::now();

private:
    double rate_;
    std::uint16_t port_;
    std::vector<std::unique_ptr<Client>> clients_;
    std::vector<pollfd> fds_;
    std::minstd_rand random_{7};
};

double percentile(std::vector<double>& all, double part) {
    if (all.empty()) return 0;
    std::sort(all.begin(), all.end());
    return all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
}

}    // namespace

int main(int argc, char** argv) {
    const std::size_t gateways = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 200;
    const double rate = argc > 2 ? std::strtod(argv[2], nullptr) : 10, seconds = argc > 3 ? std::strtod(argv[3], nullptr) : 10;
    constexpr std::uint16_t port = 18830;
    std::signal(SIGPIPE, SIG_IGN);
    mosquitto_lib_init();
    Broker broker{port};
    Fleet fleet{gateways, rate, port};
    const double up = fleet.until_connected(60s);
    if (fleet.connected() < fleet.size()) return std::printf("only %zu clients could connect\n", fleet.connected()), 1;
    const double before = broker.cpu_seconds();
    fleet.begin = Clock::now();
    while (std::chrono::duration<double>(Clock::now() - fleet.begin).count() < seconds) fleet.step(true);
    for (const auto until = Clock::now() + 1s; Clock::now() < until;) fleet.step(false);
    const double cpu = broker.cpu_seconds() - before;
    std::printf("%zu gateways, %g messages per second each, QoS 1, %g s\n\n", gateways, rate, seconds);
    std::printf(
        "| connected within | messages | acknowledged | at the reader | broker, processor | broker, memory | latency p50 | p99 "
        "|\n");
    std::printf("|---|---|---|---|---|---|---|---|\n");
    const auto messages = static_cast<double>(std::max<std::uint64_t>(fleet.totals.sent, 1));
    std::printf("| %.2f s | %llu | %llu | %zu | %.1f µs a message | %.1f MB | %.2f ms | %.2f ms |\n", up,
                static_cast<unsigned long long>(fleet.totals.sent), static_cast<unsigned long long>(fleet.totals.acknowledged),
                fleet.totals.latencies.size(), cpu / messages * 1e6, broker.resident_mb(),
                percentile(fleet.totals.latencies, 0.5), percentile(fleet.totals.latencies, 0.99));
    broker.stop();
    while (fleet.connected() > 0) fleet.step(false);
    std::printf("\nAfter a restart of the broker, all are back within ");
    for (const auto until = Clock::now() + 2s; Clock::now() < until;) fleet.step(false);
    broker.start();
    std::printf("%.1f s.\n", fleet.until_connected(60s));
    return 0;
}
