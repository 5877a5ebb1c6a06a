#include <ano/hex.hpp>
#include <ano_json/text.hpp>
#include <client/frame_stream.hpp>
#include <client/gateway_channel.hpp>
#include <client/gateway_requests.hpp>
#include <config/config_error.hpp>
#include <log/log.hpp>
#include <log/log_line.hpp>
#include <mqtt/broker.hpp>
#include <mqtt/collector.hpp>
#include <mqtt/command_line.hpp>
#include <mqtt/fleet_acl.hpp>
#include <mqtt/mqtt_config.hpp>
#include <mqtt/presence.hpp>
#include <mqtt/program.hpp>
#include <mqtt/request_admission.hpp>
#include <mqtt/spool_thread.hpp>
#include <mqtt/telemetry.hpp>
#include <mqtt/uplink.hpp>
#include <sys/files/state_folder.hpp>
#include <sys/notify.hpp>
#include <sys/random.hpp>
#include <sys/ticker.hpp>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <ctime>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;
using ano::Clock;

constexpr char filters[] = "&direction=in&elsewhere=no&batch=10ms";
constexpr char program_name[] = "anogate-mqtt";
constexpr ano::Duration request_patience = 60s, names_patience = 5s, broker_patience = 1500ms, spool_patience = 2s;
constexpr int max_messages = 64;    // received and not processed yet
constexpr std::uint32_t response_expiry_s = 60;
constexpr std::size_t run_bytes = 8;
constexpr std::uint32_t collector_session_s = 7 * 24 * 3600;
constexpr unsigned unavailable = 503;

std::uint64_t boottime_ns() {
    timespec time{};
    ::clock_gettime(CLOCK_BOOTTIME, &time);
    return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(time.tv_nsec);
}

std::string gateway_name(const MqttSettings& settings) {
    if (!settings.name.empty()) return settings.name;
    char name[256] = "gateway";
    ::gethostname(name, sizeof name - 1);
    return level_of(name);
}

std::string spool_folder(const MqttSettings& settings) {
    if (!settings.spool.empty()) return settings.spool;
    const std::string folder = state_folder();
    return folder.empty() ? "" : folder + "/mqtt";
}

BrokerSettings broker_settings(const MqttSettings& settings, std::string client_id) {
    const BrokerAddress address = broker_address(settings.broker);
    BrokerSettings broker;
    broker.host = address.host;
    broker.port = address.port;
    broker.client_id = std::move(client_id);
    broker.username = settings.username;
    broker.password_file = settings.password_file;
    broker.tls_ca = settings.tls_ca;
    broker.tls_certificate = settings.tls_certificate;
    broker.tls_key = settings.tls_key;
    return broker;
}

BrokerSettings uplink_settings(const MqttSettings& settings, const std::string& gateway, const Topics& topics) {
    BrokerSettings broker = broker_settings(settings, gateway);
    const auto delay = std::chrono::ceil<std::chrono::seconds>(settings.will_delay);
    broker.will_topic = topics.status();
    // The will waits while the session lasts.
    broker.will_delay_s = broker.session_expiry_s = static_cast<std::uint32_t>(delay.count());
    broker.subscriptions = {{topics.requests(), 1}};
    if (AllowedRequests{settings.allow}.allows("POST", "/send")) broker.subscriptions.push_back({topics.raw_down(), 0});
    return broker;
}

std::map<std::uint8_t, std::string> names_in(const std::string& body) {
    std::map<std::uint8_t, std::string> names;
    const auto json = nlohmann::json::parse(body, nullptr, false);
    if (!json.is_object() || !json.contains("devices") || !json["devices"].is_array()) return names;
    for (const auto& device : json["devices"]) {
        if (!device.is_object() || !device.contains("name") || !device["name"].is_string()) continue;
        const auto address = ano::parse_number(device.value("address", ""));
        const auto* number = address ? std::get_if<std::uint64_t>(&*address) : nullptr;
        if (number != nullptr && *number <= 0xFF) names[static_cast<std::uint8_t>(*number)] = device["name"].get<std::string>();
    }
    return names;
}

class MqttProgram {
public:
    MqttProgram(const MqttCommandLine& line, std::string run)
        : line_{line},
          settings_{line.settings},
          gateway_{gateway_name(line.settings)},
          topics_{gateway_},
          presence_{gateway_, run, ANOGATE_VERSION},
          telemetry_{settings_, gateway_, std::move(run)},
          admission_{topics_, settings_.allow} {}

    void run() {
        log_info("{} {} starts, {}, broker {}, gateway {}", program_name, ANOGATE_VERSION,
                 line_.config_file.empty() ? "no configuration file" : line_.config_file, printable(settings_.broker),
                 printable(gateway_));
        wait_for_signal();
        spool_.start();    // it starts the broker
        stream_.start();
        if (accepts_frames_) channel_.start();
        quarters_.start(250ms);
        seconds_.start(1s);
        minutes_.start(60s);
        notify_systemd("READY=1", {}, Patience::some);
        if (const auto interval = watchdog_interval()) watchdog_.start(*interval);
        io_.run();
    }

    /// What was not acknowledged is in the spool afterwards.
    void leave() {
        stream_.stop();
        if (uplink_.is_connected())
            broker_.publish({.topic = topics_.status(),
                             .payload = presence_.farewell(connection_),
                             .is_retained = true,
                             .content_type = "application/json"});
        if (!broker_.stop(broker_patience)) log_warning("the thread of the broker hangs");
        io_.restart();
        io_.poll();    // what the broker acknowledged meanwhile
        uplink_.store_all();
        if (!spool_.stop(spool_patience)) log_warning("the disk of the spool hangs");
        io_.restart();
        io_.poll();    // the last state of the spool
        const DeliveryCounts last = counts();
        log_info("{} messages acknowledged, {} records in the spool, {} dropped, {} frames lost by the gateway", last.published,
                 last.waiting, last.dropped, last.gateway_lost);
    }

private:
    void wait_for_signal() {
        signals_.async_wait([this](error_code ec, int signal) {
            if (ec) return;
            log_info("stopping ({})", signal == SIGTERM ? "SIGTERM" : "SIGINT");
            io_.stop();
        });
    }

    void on_frame(const StreamedFrame& frame) {
        const auto bytes = frame.record.frame.bytes();
        if (settings_.raw && uplink_.is_connected() && frame.record.direction == Direction::in && broker_.has_room())
            broker_.publish(
                {.topic = topics_.raw_up(), .payload = {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, .qos = 0});
        if (auto record = telemetry_.receive(frame.link, frame.record, Clock::now())) uplink_.add(*std::move(record));
    }

    // In the thread of the broker.
    void receive(BrokerMessage message) {
        if (++messages_ > max_messages) {
            --messages_;
            return;
        }
        asio::post(io_, [this, message = std::move(message), received_ns = boottime_ns()] {
            --messages_;
            if (message.topic == topics_.raw_down()) return send_frames(message);
            on_request({.topic = message.topic,
                        .payload = message.payload,
                        .correlation = message.correlation,
                        .response_topic = message.response_topic,
                        .is_retained = message.is_retained,
                        .expiry_s = message.expiry_s,
                        .received_ns = received_ns});
        });
    }

    // Only whole frames, and none that waited at the broker.
    void send_frames(const BrokerMessage& message) {
        if (message.is_retained) return;
        ano::Bytes rest{reinterpret_cast<const std::uint8_t*>(message.payload.data()), message.payload.size()};
        while (const auto frame = ano::frame_at(rest)) {
            channel_.send(frame->bytes());
            rest = rest.subspan(frame->bytes().size());
        }
    }

    void on_request(const RequestMessage& message) {
        const auto decision = admission_.admit(message, boottime_ns());
        if (const auto* response = std::get_if<Response>(&decision)) return publish(*response);
        const auto* request = std::get_if<AdmittedRequest>(&decision);
        if (request == nullptr) return;
        if (!RequestAdmission::is_kept(request->key)) return execute(*request);
        log_info("request {}: {} {}", printable(request->key), request->method, printable(request->target));
        spool_.begin_request(request->key, [this, request = *request](bool is_new) {
            if (is_new) execute(request);
            else finish(request.key, 0, "the request was begun before");
        });
    }

    void execute(const AdmittedRequest& request) {
        if (boottime_ns() >= request.until_ns) return publish(keep(request.key, admission_.expire(request.key)));
        const bool is_asked = requests_.ask(request.method, request.target, request.body, request_patience,
                                            [this, key = request.key](const http::Outcome& outcome) {
                                                const bool has_answer = outcome.fault.empty() && outcome.answer.status != 0;
                                                finish(key, has_answer ? outcome.answer.status : 0,
                                                       has_answer ? outcome.answer.body : outcome.fault);
                                            });
        if (!is_asked) finish(request.key, unavailable, R"({"error": "too many requests are running"})");
    }

    void finish(const std::string& key, unsigned status, const std::string& body) {
        publish(keep(key, admission_.finish(key, status, body)));
    }

    Response keep(const std::string& key, Response response) {
        if (RequestAdmission::is_kept(key)) spool_.end_request(key, response.payload);
        return response;
    }

    // A response that can't be published is returned again when the request is repeated.
    void publish(const Response& response) {
        if (!uplink_.is_connected() || response.topic.empty()) return;
        broker_.publish({.topic = response.topic,
                         .payload = response.payload,
                         .expiry_s = response_expiry_s,
                         .correlation = response.correlation,
                         .content_type = "application/json"});
    }

    void on_connected(std::uint64_t connection, std::size_t window) {
        connection_ = connection;
        log_info("connected to the broker");
        if (!settings_.tls_certificate.empty()) life_ = certificate_life(settings_.tls_certificate);
        publish_status();
        uplink_.on_connected(window);
    }

    void on_disconnected(const std::string& why) {
        log_warning("broker {}: {}; connecting again", printable(settings_.broker), printable(why));
        uplink_.on_disconnected();
    }

    DeliveryCounts counts() const {
        DeliveryCounts counts = uplink_.counts();
        counts.gateway_lost = gateway_lost_;
        return counts;
    }

    void publish_status() {
        if (connection_ == 0) return;
        status_counts_ = counts();
        status_devices_ = telemetry_.devices().size();
        broker_.publish({.topic = topics_.status(),
                         .payload = presence_.birth(connection_, telemetry_.devices(), names_, status_counts_),
                         .is_retained = true,
                         .content_type = "application/json"});
    }

    void every_second() {
        broker_.check(Clock::now());
        if (telemetry_.devices().size() == status_devices_) return;
        ask_names();
        if (uplink_.is_connected()) publish_status();
    }

    void every_minute() {
        ask_names();
        renew_certificate();
        if (uplink_.is_connected() && counts() != status_counts_) publish_status();
    }

    void ask_names() {
        if (!stream_.is_open()) return;
        requests_.ask("GET", "/devices", "", names_patience, [this](const http::Outcome& outcome) {
            if (auto names = names_in(outcome.answer.body); !names.empty() && names != names_) {
                names_ = std::move(names);
                if (uplink_.is_connected()) publish_status();
            }
        });
    }

    void renew_certificate() {
        if (!life_ || !uplink_.is_connected() || std::time(nullptr) < renewal_time(*life_, gateway_)) return;
        const auto now = certificate_life(settings_.tls_certificate);
        if (!now || now == life_) return;
        log_info("the certificate was renewed; connecting again");
        broker_.reconnect();
    }

    const MqttCommandLine& line_;
    const MqttSettings& settings_;
    const std::string gateway_;
    const Topics topics_;
    const Presence presence_;
    asio::io_context io_{1};
    asio::signal_set signals_{io_, SIGTERM, SIGINT};
    Telemetry telemetry_;
    RequestAdmission admission_;
    const bool accepts_frames_ = AllowedRequests{settings_.allow}.allows("POST", "/send");
    std::atomic<int> messages_{0};
    std::uint64_t connection_ = 0, gateway_lost_ = 0;
    std::map<std::uint8_t, std::string> names_;    // of devices
    DeliveryCounts status_counts_;
    std::size_t status_devices_ = 0;
    std::optional<CertificateLife> life_;    // of the certificate in use
    SpoolThread spool_{io_,
                       spool_folder(settings_),
                       {settings_.spool_size, static_cast<std::uint64_t>(
                                                  std::chrono::duration_cast<std::chrono::seconds>(settings_.spool_age).count())},
                       {.next = [this](SpooledBatch batch) { uplink_.on_spooled(std::move(batch)); },
                        .state = [this](const SpoolState& state) { uplink_.on_spool_state(state); },
                        .report = [](const std::string& text) { log_warning("{}", printable(text, 400)); },
                        .requests =
                            [this](const std::vector<KnownRequest>& known) {
                                for (const KnownRequest& one : known) admission_.restore(one.key, one.response, boottime_ns());
                                broker_.start();
                            }}};
    Broker broker_{uplink_settings(settings_, gateway_, topics_),
                   {.will = [this](std::uint64_t connection) { return presence_.will(connection); },
                    .connected = [this](std::uint64_t connection,
                                        std::size_t window) { asio::post(io_, [=, this] { on_connected(connection, window); }); },
                    .disconnected = [this](const std::string& why) { asio::post(io_, [=, this] { on_disconnected(why); }); },
                    .answered = [this](std::uint64_t id,
                                       std::uint8_t reason) { asio::post(io_, [=, this] { uplink_.on_answered(id, reason); }); },
                    .received = [this](BrokerMessage message) { receive(std::move(message)); }}};
    Uplink uplink_{io_, topics_, settings_.backlog_rate, broker_, spool_};
    GatewayRequests requests_{io_, settings_.control, program_name};
    GatewayChannel channel_{io_, settings_.control, "mqtt", {}};
    FrameStream stream_{io_,
                        settings_.control,
                        filters,
                        {.frame = [this](const StreamedFrame& frame) { on_frame(frame); },
                         .decoding = [this](const DecodingPtr& decoding) { telemetry_.use(decoding); },
                         .lost = [this](std::uint64_t count) { gateway_lost_ += count; },
                         .opened = [] { log_info("connected to the gateway"); },
                         .closed = [](const std::string& why) { log_warning("{}; connecting again", printable(why)); }}};
    Ticker quarters_{io_, [this] { uplink_.on_time(); }};
    Ticker seconds_{io_, [this] { every_second(); }};
    Ticker minutes_{io_, [this] { every_minute(); }};
    Ticker watchdog_{io_, [] { notify_systemd("WATCHDOG=1"); }};
};

// anogate-mqtt --collect
class CollectorProgram {
public:
    explicit CollectorProgram(const MqttCommandLine& line) : line_{line}, collector_{line.to, line.mcap} {}

    int run() {
        if (const auto opened = collector_.open(); !opened) {
            std::cerr << program_name << ": " << printable(opened.error()) << '\n';
            return 1;
        }
        start_log(line_.settings.log);
        signals_.async_wait([this](error_code, int) { io_.stop(); });
        broker_.start();
        seconds_.start(1s);
        minutes_.start(60s);
        notify_systemd("READY=1", {}, Patience::some);
        if (const auto interval = watchdog_interval()) watchdog_.start(*interval);
        io_.run();
        broker_.stop(broker_patience);
        const auto closed = collector_.close();
        log_counts();
        if (!closed) log_warning("{}", printable(closed.error()));
        end_log();
        ::_exit(closed ? 0 : 1);
    }

private:
    static BrokerSettings settings_of(const MqttCommandLine& line) {
        BrokerSettings broker = broker_settings(line.settings, level_of(gateway_name(line.settings)) + "-collect");
        const std::string all = std::string{topic_root} + "/+/";
        broker.session_expiry_s = collector_session_s;
        broker.subscriptions = {{all + "up/+/+", 1}, {all + "backlog/+", 1}};
        return broker;
    }

    // A message that can't be written must not be acknowledged.
    void receive(const BrokerMessage& message) {
        const auto written = collector_.receive(message, static_cast<std::uint64_t>(std::time(nullptr)));
        if (written) return;
        log_warning("{}; stopping", printable(written.error()));
        end_log();
        ::_exit(1);
    }

    void log_counts() {
        const auto& counts = collector_.counts();
        log_info("{} records, {} repeats dropped, {} invalid", counts.records.load(), counts.repeats.load(),
                 counts.invalid.load());
    }

    const MqttCommandLine& line_;
    asio::io_context io_{1};
    asio::signal_set signals_{io_, SIGTERM, SIGINT};
    Collector collector_;
    Broker broker_{settings_of(line_),
                   {.connected = [](auto, auto) { log_info("connected to the broker"); },
                    .disconnected =
                        [this](const std::string& why) {
                            log_warning("broker {}: {}; connecting again", printable(line_.settings.broker), printable(why));
                        },
                    .received = [this](const BrokerMessage& message) { receive(message); }}};
    Ticker seconds_{io_, [this] { broker_.check(Clock::now()); }};
    Ticker minutes_{io_, [this] { log_counts(); }};
    Ticker watchdog_{io_, [] { notify_systemd("WATCHDOG=1"); }};
};

}    // namespace

int run_mqtt(int argc, char** argv) {
    const auto parsed = parse_mqtt_command_line(argc, argv);
    if (const auto* exit = std::get_if<MqttExit>(&parsed)) {
        (exit->code == 0 ? std::cout : std::cerr) << exit->text;
        return exit->code;
    }
    const auto& line = std::get<MqttCommandLine>(parsed);
    if (line.print_acl) std::cout << fleet_acl();
    if (line.print_config) std::cout << print_mqtt_config(line.settings);
    if (line.check || line.print_config || line.print_acl) return 0;
    std::signal(SIGPIPE, SIG_IGN);
    if (line.collect) return CollectorProgram{line}.run();
    const auto run = random_hex(run_bytes);
    if (!run) {
        std::cerr << program_name << ": no random numbers are available\n";
        return 1;
    }
    start_log(line.settings.log);
    MqttProgram program{line, *run};
    program.run();
    program.leave();
    end_log();
    ::_exit(0);
}

}    // namespace anogate
