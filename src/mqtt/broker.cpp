#include <mqtt/broker.hpp>
#include <sys/errors.hpp>
#include <sys/files/read_file.hpp>
#include <sys/thread_signals.hpp>

#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <random>
#include <system_error>
#include <unordered_map>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr int protocol_error_reason = 0x90, too_large_reason = 0x95, step_ms = 500, max_packets = 100;
constexpr std::uint16_t default_receive_maximum = 65535, our_receive_maximum = 20;
constexpr std::uint32_t max_received = 128 * 1024;    // bytes of a packet; the broker drops larger ones
constexpr std::size_t max_password = 4096;
constexpr auto farewell_time = 500ms;

class Properties {
public:
    Properties() = default;
    Properties(const Properties&) = delete;
    Properties& operator=(const Properties&) = delete;
    ~Properties() { mosquitto_property_free_all(&list_); }

    void add(int name, std::uint32_t number) { mosquitto_property_add_int32(&list_, name, number); }
    void add_text(int name, const std::string& text) { mosquitto_property_add_string(&list_, name, text.c_str()); }
    void add_bytes(int name, const std::string& bytes) {
        mosquitto_property_add_binary(&list_, name, bytes.data(), static_cast<std::uint16_t>(bytes.size()));
    }
    mosquitto_property* get() const { return list_; }
    /// For functions of the library that take ownership.
    mosquitto_property* release() { return std::exchange(list_, nullptr); }

private:
    mosquitto_property* list_ = nullptr;
};

std::string text_of(const mosquitto_property* list, int name) {
    char* text = nullptr;
    if (mosquitto_property_read_string(list, name, &text, false) == nullptr || text == nullptr) return {};
    std::string copy{text};
    ::free(text);
    return copy;
}

std::string bytes_of(const mosquitto_property* list, int name) {
    void* bytes = nullptr;
    std::uint16_t size = 0;
    if (mosquitto_property_read_binary(list, name, &bytes, &size, false) == nullptr || bytes == nullptr) return {};
    std::string copy{static_cast<const char*>(bytes), size};
    ::free(bytes);
    return copy;
}

std::string error_of(int code) { return code == MOSQ_ERR_ERRNO ? error_text(errno) : mosquitto_strerror(code); }

std::string first_line(const std::string& file, std::string& fault) {
    std::error_code error;
    std::string text = read_file(file, max_password, error);
    if (error) fault = file + ": " + error.message();
    return text.substr(0, text.find_first_of("\r\n"));
}

// A signal that ends a system call of the broker's thread.
constexpr int interruption = SIGURG;

void let_interrupt() {
    struct sigaction action {};
    action.sa_handler = [](int) {};
    ::sigaction(interruption, &action, nullptr);
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, interruption);
    ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

std::int64_t ns(ano::TimePoint time) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

}    // namespace

// One attempt, and the connection that follows. A new client of the library for each: it has no queue, and reads the files again.
class Broker::Connection {
public:
    explicit Connection(Broker& owner)
        : owner_{owner},
          settings_{owner.settings_},
          client_{mosquitto_new(settings_.client_id.empty() ? nullptr : settings_.client_id.c_str(), settings_.client_id.empty(),
                                this)} {}
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;
    ~Connection() { mosquitto_destroy(client_); }

    std::string open();
    /// Until it ends; returns why.
    std::string serve();
    bool is_connected() const { return is_connected_; }
    ano::TimePoint connected_at() const { return connected_at_; }

private:
    static Connection& of(void* object) { return *static_cast<Connection*>(object); }
    std::string prepare();
    void set_callbacks();
    void on_connect(int reason, const mosquitto_property* properties);
    void on_message(const mosquitto_message& message, const mosquitto_property* properties);
    void on_publish(int mid, int reason);
    int read(bool is_readable);
    int step();
    void send_queued();
    void send(const Publication& publication);
    void say_farewell();

    Broker& owner_;
    const BrokerSettings& settings_;
    mosquitto* client_;
    bool is_connected_ = false, has_ended_ = false;
    ano::TimePoint connected_at_{};
    std::string why_;
    std::unordered_map<int, std::uint64_t> ids_;    // of publications in flight, by the number of their packet
};

std::string Broker::Connection::prepare() {
    if (client_ == nullptr) return "no memory";
    mosquitto_int_option(client_, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
    mosquitto_int_option(client_, MOSQ_OPT_RECEIVE_MAXIMUM, our_receive_maximum);
    mosquitto_int_option(client_, MOSQ_OPT_TCP_NODELAY, 1);
    std::string fault;
    if (!settings_.username.empty()) {
        const std::string password = settings_.password_file.empty() ? "" : first_line(settings_.password_file, fault);
        if (!fault.empty()) return fault;
        mosquitto_username_pw_set(client_, settings_.username.c_str(),
                                  settings_.password_file.empty() ? nullptr : password.c_str());
    }
    if (!settings_.tls_ca.empty()) {
        const auto file = [](const std::string& name) { return name.empty() ? nullptr : name.c_str(); };
        const int code = mosquitto_tls_set(client_, settings_.tls_ca.c_str(), nullptr, file(settings_.tls_certificate),
                                           file(settings_.tls_key), nullptr);
        if (code != MOSQ_ERR_SUCCESS) return "TLS: " + error_of(code) + ": " + settings_.tls_ca;
    }
    if (!settings_.will_topic.empty()) {
        const std::string will = owner_.events_.will(owner_.connection_ + 1);
        Properties properties;
        if (settings_.will_delay_s > 0) properties.add(MQTT_PROP_WILL_DELAY_INTERVAL, settings_.will_delay_s);
        const int code = mosquitto_will_set_v5(client_, settings_.will_topic.c_str(), static_cast<int>(will.size()), will.data(),
                                               1, true, properties.get());
        if (code != MOSQ_ERR_SUCCESS) return error_of(code);
        properties.release();
    }
    set_callbacks();
    return {};
}

void Broker::Connection::set_callbacks() {
    mosquitto_connect_v5_callback_set(client_,
                                      [](mosquitto*, void* object, int reason, int, const mosquitto_property* properties) {
                                          of(object).on_connect(reason, properties);
                                      });
    mosquitto_disconnect_v5_callback_set(client_, [](mosquitto*, void* object, int reason, const mosquitto_property*) {
        Connection& connection = of(object);
        connection.has_ended_ = true;
        if (connection.why_.empty())
            connection.why_ = reason < 0x80 ? error_of(reason)
                                            : std::string{"the broker disconnected: "} + mosquitto_reason_string(reason);
    });
    mosquitto_publish_v5_callback_set(client_, [](mosquitto*, void* object, int mid, int reason, const mosquitto_property*) {
        of(object).on_publish(mid, reason);
    });
    mosquitto_message_v5_callback_set(
        client_, [](mosquitto*, void* object, const mosquitto_message* message, const mosquitto_property* properties) {
            of(object).on_message(*message, properties);
        });
}

std::string Broker::Connection::open() {
    if (std::string fault = prepare(); !fault.empty()) return fault;
    Properties properties;
    properties.add(MQTT_PROP_MAXIMUM_PACKET_SIZE, max_received);
    if (settings_.session_expiry_s > 0) properties.add(MQTT_PROP_SESSION_EXPIRY_INTERVAL, settings_.session_expiry_s);
    const auto keep_alive = std::chrono::duration_cast<std::chrono::seconds>(settings_.keep_alive);
    owner_.connecting_since_ns_ = ns(ano::Clock::now());
    const int code = mosquitto_connect_bind_v5(client_, settings_.host.c_str(), settings_.port,
                                               static_cast<int>(keep_alive.count()), nullptr, properties.get());
    owner_.connecting_since_ns_ = 0;
    if (code == MOSQ_ERR_ERRNO && errno == EINTR) return "no answer";
    return code == MOSQ_ERR_SUCCESS ? std::string{} : error_of(code);
}

std::string Broker::Connection::serve() {
    const auto give_up_at = ano::Clock::now() + settings_.patience;
    while (!has_ended_) {
        if (owner_.stopping_) {
            say_farewell();
            break;
        }
        if (owner_.reconnecting_.exchange(false) && is_connected_) {
            why_ = "connecting again for renewed certificates";
            mosquitto_disconnect_v5(client_, MQTT_RC_DISCONNECT_WITH_WILL_MSG, nullptr);
            break;
        }
        if (!is_connected_ && ano::Clock::now() >= give_up_at) return "no answer";
        if (const int code = step(); code != MOSQ_ERR_SUCCESS && why_.empty()) why_ = error_of(code), has_ended_ = true;
    }
    return why_;
}

// One round: waits for the socket or for something to publish.
int Broker::Connection::step() {
    const int fd = mosquitto_socket(client_);
    if (fd < 0) return MOSQ_ERR_NO_CONN;
    const bool must_write = mosquitto_want_write(client_);
    const auto events = static_cast<short>(must_write ? POLLIN | POLLOUT : POLLIN);
    pollfd fds[] = {{fd, events, 0}, {owner_.wake_fd_.get(), POLLIN, 0}};
    ::poll(fds, 2, step_ms);
    std::uint64_t count = 0;
    if ((fds[1].revents & POLLIN) != 0) {
        [[maybe_unused]] const auto size = ::read(owner_.wake_fd_.get(), &count, sizeof count);
    }
    int code = read((fds[0].revents & ~POLLOUT) != 0);
    if (code == MOSQ_ERR_SUCCESS && mosquitto_want_write(client_)) code = mosquitto_loop_write(client_, 1);
    if (code == MOSQ_ERR_SUCCESS) code = mosquitto_loop_misc(client_);
    if (code == MOSQ_ERR_SUCCESS && is_connected_) send_queued();
    return code;
}

// The library may return with decrypted bytes left, for which the socket does not become readable again.
int Broker::Connection::read(bool is_readable) {
    const auto has_decrypted = [this] {
        auto* const ssl = static_cast<SSL*>(mosquitto_ssl_get(client_));
        return ssl != nullptr && SSL_pending(ssl) > 0;
    };
    int code = MOSQ_ERR_SUCCESS;
    if (!is_readable && !has_decrypted()) return code;
    for (int i = 0; i < max_packets && code == MOSQ_ERR_SUCCESS; ++i) {
        code = mosquitto_loop_read(client_, max_packets);
        if (!has_decrypted()) break;
    }
    return code;
}

void Broker::Connection::on_connect(int reason, const mosquitto_property* properties) {
    if (reason != 0) {
        why_ = std::string{"the broker refused the connection: "} + mosquitto_reason_string(reason);
        has_ended_ = true;
        return;
    }
    for (const Subscription& one : settings_.subscriptions)
        mosquitto_subscribe_v5(client_, nullptr, one.topic.c_str(), one.qos, 0, nullptr);
    std::uint16_t window = default_receive_maximum;
    mosquitto_property_read_int16(properties, MQTT_PROP_RECEIVE_MAXIMUM, &window, false);
    is_connected_ = true;
    connected_at_ = ano::Clock::now();
    while (owner_.queue_.pop()) {}    // of an earlier connection
    owner_.events_.connected(++owner_.connection_, std::min<std::size_t>(window, max_window));
}

void Broker::Connection::on_message(const mosquitto_message& message, const mosquitto_property* properties) {
    BrokerMessage received;
    received.topic = message.topic;
    received.payload.assign(static_cast<const char*>(message.payload), static_cast<std::size_t>(message.payloadlen));
    received.is_retained = message.retain;
    received.correlation = bytes_of(properties, MQTT_PROP_CORRELATION_DATA);
    received.response_topic = text_of(properties, MQTT_PROP_RESPONSE_TOPIC);
    std::uint32_t expiry = 0;
    if (mosquitto_property_read_int32(properties, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, &expiry, false) != nullptr)
        received.expiry_s = expiry;
    owner_.events_.received(std::move(received));
}

void Broker::Connection::on_publish(int mid, int reason) {
    const auto found = ids_.find(mid);
    if (found == ids_.end()) return;
    const std::uint64_t id = found->second;
    ids_.erase(found);
    owner_.events_.answered(id, static_cast<std::uint8_t>(reason));
}

// The library's queue has no bound: nothing is added while it has something to write.
void Broker::Connection::send_queued() {
    for (int i = 0; i < max_packets && !mosquitto_want_write(client_); ++i) {
        const auto next = owner_.queue_.pop();
        if (!next) return;
        send(*next);
    }
    if (!owner_.queue_.empty()) owner_.wake();
}

void Broker::Connection::send(const Publication& publication) {
    Properties properties;
    if (publication.expiry_s != 0) properties.add(MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, publication.expiry_s);
    if (!publication.correlation.empty()) properties.add_bytes(MQTT_PROP_CORRELATION_DATA, publication.correlation);
    if (!publication.content_type.empty()) properties.add_text(MQTT_PROP_CONTENT_TYPE, publication.content_type);
    int mid = 0;
    const int code = mosquitto_publish_v5(client_, &mid, publication.topic.c_str(), static_cast<int>(publication.payload.size()),
                                          publication.payload.data(), publication.qos, publication.is_retained, properties.get());
    if (publication.id == 0 || publication.qos == 0) return;
    if (code == MOSQ_ERR_SUCCESS) ids_.emplace(mid, publication.id);
    else if (code == MOSQ_ERR_OVERSIZE_PACKET || code == MOSQ_ERR_PAYLOAD_SIZE)
        owner_.events_.answered(publication.id, too_large_reason);
    else if (code != MOSQ_ERR_NO_CONN && code != MOSQ_ERR_CONN_LOST)
        owner_.events_.answered(publication.id, protocol_error_reason);
}

void Broker::Connection::say_farewell() {
    if (!is_connected_) return;
    const auto until = ano::Clock::now() + farewell_time;
    while (!has_ended_ && (!owner_.queue_.empty() || !ids_.empty() || mosquitto_want_write(client_)) && ano::Clock::now() < until)
        if (step() != MOSQ_ERR_SUCCESS) return;
    mosquitto_disconnect_v5(client_, MQTT_RC_NORMAL_DISCONNECTION, nullptr);
}

Broker::Broker(BrokerSettings settings, BrokerEvents events)
    : settings_{std::move(settings)}, events_{std::move(events)}, wake_fd_{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)} {
    mosquitto_lib_init();
}

Broker::~Broker() { stop({}); }

void Broker::start() {
    thread_ = begin_thread([this] { run(); });
}

bool Broker::publish(Publication publication) {
    if (!queue_.push(std::move(publication))) return false;
    wake();
    return true;
}

void Broker::wake() noexcept {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto size = ::write(wake_fd_.get(), &one, sizeof one);    // full: it is awake
}

void Broker::reconnect() {
    reconnecting_ = true;
    wake();
}

// A connect to an address that drops packets lasts two minutes: the network may be back long before.
void Broker::check(ano::TimePoint now) {
    const std::int64_t since = connecting_since_ns_;
    if (since != 0 && ns(now) - since > std::chrono::nanoseconds{settings_.patience}.count())
        ::pthread_kill(thread_.native_handle(), interruption);
}

void Broker::run() {
    let_interrupt();
    std::minstd_rand random{std::random_device{}()};
    bool is_reported = false;
    auto lost_at = ano::Clock::now();    // the last connection that was stable
    while (!stopping_) {
        std::string why;
        {
            Connection connection{*this};
            why = connection.open();
            if (why.empty()) why = connection.serve();
            if (connection.is_connected()) {
                const auto now = ano::Clock::now();
                if (now - connection.connected_at() >= stable_connection) lost_at = now;
                is_reported = false;
            }
        }
        if (stopping_) break;
        if (!std::exchange(is_reported, true)) events_.disconnected(why);
        pause(reconnect_pause(ano::Clock::now() - lost_at, std::uniform_real_distribution<>{0, 1}(random)));
    }
    const std::lock_guard lock{mutex_};
    has_ended_ = true;
    ended_.notify_all();
}

void Broker::pause(std::chrono::milliseconds time) {
    const auto until = ano::Clock::now() + time;
    while (!stopping_ && ano::Clock::now() < until) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - ano::Clock::now());
        ::poll(nullptr, 0, static_cast<int>(std::clamp<std::int64_t>(left.count(), 1, 100)));
    }
}

bool Broker::stop(ano::Duration patience) {
    if (!thread_.joinable()) return true;
    stopping_ = true;
    wake();
    const auto until = ano::Clock::now() + patience;
    std::unique_lock lock{mutex_};
    while (!has_ended_ && ano::Clock::now() < until) {
        if (connecting_since_ns_ != 0) ::pthread_kill(thread_.native_handle(), interruption);
        ended_.wait_for(lock, std::min<ano::Duration>(50ms, until - ano::Clock::now()));
    }
    const bool has_ended = has_ended_;
    lock.unlock();
    if (has_ended) thread_.join();
    else thread_.detach();
    return has_ended;
}

std::optional<CertificateLife> certificate_life(const std::string& file) {
    std::error_code error;
    const std::string text = read_file(file, max_config_size, error);
    const std::unique_ptr<BIO, decltype(&BIO_free)> bio{BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free};
    const std::unique_ptr<X509, decltype(&X509_free)> certificate{PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr),
                                                                  X509_free};
    if (!certificate) return std::nullopt;
    std::tm begin{}, end{};
    if (ASN1_TIME_to_tm(X509_get0_notBefore(certificate.get()), &begin) != 1 ||
        ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &end) != 1)
        return std::nullopt;
    return CertificateLife{::timegm(&begin), ::timegm(&end)};
}

}    // namespace anogate
