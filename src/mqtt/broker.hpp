// The connection to an MQTT 5 broker, in a thread of its own: resolving, connecting and TLS may block it, and nothing else. Only
// broker.cpp knows the library.
#pragma once
#include <ano/time.hpp>
#include <mqtt/reconnection.hpp>
#include <sys/thread_queue.hpp>
#include <sys/unique_fd.hpp>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace anogate {

struct Subscription {
    std::string topic;
    int qos = 1;
};

struct BrokerSettings {
    std::string host;
    std::uint16_t port = 1883;
    std::string client_id;
    std::string username, password_file;
    std::string tls_ca, tls_certificate, tls_key;    // files, read again for each connection
    std::string will_topic;                          // empty: no will
    std::uint32_t will_delay_s = 0;
    std::uint32_t session_expiry_s = 0;    // so long the broker keeps messages for us
    std::vector<Subscription> subscriptions;
    ano::Duration keep_alive = std::chrono::seconds{15};
    ano::Duration patience = std::chrono::seconds{10};    // for an answer to a connection
};

struct Publication {
    std::uint64_t id = 0;    // of BrokerEvents::answered; 0: no answer is expected (QoS 0 or not interesting)
    std::string topic{}, payload{};
    int qos = 1;
    bool is_retained = false;
    std::uint32_t expiry_s = 0;    // 0: never
    std::string correlation{};
    std::string content_type{};
};

struct BrokerMessage {
    std::string topic{}, payload{}, correlation{}, response_topic{};
    bool is_retained = false;
    std::optional<std::uint32_t> expiry_s{};    // left
};

/// Called in the broker's thread.
struct BrokerEvents {
    /// The will for a connection that is opened next; connections that the broker refused are not counted.
    std::function<std::string(std::uint64_t connection)> will = [](auto) { return std::string{}; };
    /// At most `window` publications with QoS 1 may be in flight.
    std::function<void(std::uint64_t connection, std::size_t window)> connected = [](auto, auto) {};
    /// Once at the end of a connection, or after the first of several attempts failed. `why`: one clause.
    std::function<void(const std::string& why)> disconnected = [](auto&) {};
    /// `reason`: of PUBACK.
    std::function<void(std::uint64_t id, std::uint8_t reason)> answered = [](auto, auto) {};
    std::function<void(BrokerMessage)> received = [](auto) {};
};

class Broker {
public:
    static constexpr std::size_t max_queued = 512, max_window = 256;

    Broker(BrokerSettings settings, BrokerEvents events);
    ~Broker();
    Broker(const Broker&) = delete;
    Broker& operator=(const Broker&) = delete;

    void start();
    bool has_room() const noexcept { return queue_.has_room(); }
    /// From one thread. False: the queue is full. What is queued without a connection is dropped.
    bool publish(Publication publication);
    /// At least every second: an attempt that hangs is given up.
    void check(ano::TimePoint now);
    /// Connects again, for renewed certificates.
    void reconnect();
    /// Publishes what is queued, disconnects, and waits for the end, but at most `patience`. False: the thread hangs in the resolver or
    /// in a connect; only _exit() ends the program.
    bool stop(ano::Duration patience);

private:
    class Connection;
    void run();
    std::string connect_once();
    void pause(std::chrono::milliseconds time);
    void wake() noexcept;

    const BrokerSettings settings_;
    const BrokerEvents events_;
    ThreadQueue<Publication> queue_{max_queued};
    UniqueFd wake_fd_;
    std::thread thread_;
    std::atomic<bool> stopping_{false}, reconnecting_{false};
    std::atomic<std::int64_t> connecting_since_ns_{0};    // 0: not in the library's connect
    std::uint64_t connection_ = 0;
    std::mutex mutex_;
    std::condition_variable ended_;
    bool has_ended_ = false;
};

/// The times of the first certificate in a file; std::nullopt: there is none.
std::optional<CertificateLife> certificate_life(const std::string& file);

}    // namespace anogate
