#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <client/frame_stream.hpp>
#include <client/gateway_channel.hpp>
#include <client/gateway_requests.hpp>
#include <config/config_error.hpp>
#include <http/client/percent_encoded.hpp>
#include <log/log.hpp>
#include <log/log_line.hpp>
#include <ros2/bridge.hpp>
#include <ros2/command_line.hpp>
#include <ros2/interfaces.hpp>
#include <ros2/line_limit.hpp>
#include <ros2/program.hpp>
#include <ros2/ros2_config.hpp>
#include <sys/notify.hpp>
#include <sys/ticker.hpp>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <iostream>
#include <optional>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;
using ano::Clock;

constexpr char filters[] = "&direction=in&elsewhere=no&batch=2ms";
constexpr char program_name[] = "anogate-ros2";
constexpr ano::Duration list_time = 3s, command_patience = 60s, request_patience = 5s, leave_patience = 1s;
constexpr int max_samples = 256;    // received and not processed yet

std::uint64_t now_ns() {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count());
}

// For --list: nobody receives anything.
class NoBus final : public Bus {
public:
    Topic advertise(TopicSpec) override { return count_++; }
    void withdraw(Topic) override {}
    bool has_subscribers(Topic) const override { return false; }
    void publish(Topic, std::string_view) override {}
    std::size_t subscribe(TopicSpec) override { return count_++; }

private:
    std::size_t count_ = 0;
};

class NoOutput final : public BridgeOutput {
public:
    bool send(ano::Bytes) override { return false; }
    bool call(std::uint8_t, const CommandText&, std::function<void(const http::Outcome&)>) override { return false; }
    void log(std::string_view) override {}
    void warn(std::string_view) override {}
};

std::vector<DeviceNote> devices_in(const std::string& body) {
    std::vector<DeviceNote> notes;
    const auto json = nlohmann::json::parse(body, nullptr, false);
    if (!json.is_object() || !json.contains("devices") || !json["devices"].is_array()) return notes;
    for (const auto& device : json["devices"]) {
        if (!device.is_object() || !device.contains("name") || !device["name"].is_string()) continue;
        const auto address = ano::parse_number(device.value("address", ""));
        const auto* number = address ? std::get_if<std::uint64_t>(&*address) : nullptr;
        if (number != nullptr && *number <= 0xFF)
            notes.push_back({static_cast<std::uint8_t>(*number), device["name"].get<std::string>()});
    }
    return notes;
}

// Prints the topics of the devices that are heard within list_time.
class TopicLister {
public:
    explicit TopicLister(const Ros2Settings& settings) : settings_{settings}, bridge_{settings, bus_, output_} {}

    int run() {
        requests_.ask("GET", "/devices", "", request_patience, [this](const http::Outcome& outcome) {
            bridge_.use(devices_in(outcome.answer.body));
            stream_.start();
        });
        io_.run();
        if (!fault_.empty()) {
            std::cerr << program_name << ": " << printable(fault_) << '\n';
            return 1;
        }
        std::cout << bridge_.list(list_time);
        return 0;
    }

private:
    void opened() {
        end_.expires_after(list_time);
        end_.async_wait([this](error_code ec) {
            if (!ec) io_.stop();
        });
    }

    const Ros2Settings& settings_;
    NoBus bus_;
    NoOutput output_;
    Bridge bridge_;
    std::string fault_;
    asio::io_context io_{1};
    asio::steady_timer end_{io_};
    GatewayRequests requests_{io_, settings_.control, program_name};
    FrameStream stream_{io_,
                        settings_.control,
                        filters,
                        {.frame = [this](const StreamedFrame& frame) { bridge_.receive(frame.link, frame.record, Clock::now()); },
                         .decoding = [this](const DecodingPtr& decoding) { bridge_.use(decoding); },
                         .opened = [this] { opened(); },
                         .closed =
                             [this](const std::string& why) {
                                 fault_ = why;
                                 io_.stop();
                             }}};
};

class Ros2Program final : BridgeOutput {
public:
    explicit Ros2Program(const Ros2CommandLine& line)
        : line_{line},
          settings_{line.settings},
          bus_{make_network_bus(settings_.domain, {.sample = [this](Sample sample) { receive_sample(std::move(sample)); },
                                                   .log = [this](const std::string& text) { log_dds(text); }})},
          bridge_{settings_, *bus_, *this} {}

    void run() {
        log_info("{} {} starts, {}, domain {}", program_name, ANOGATE_VERSION,
                 line_.config_file.empty() ? "no configuration file" : line_.config_file, settings_.domain);
        wait_for_signal();
        join();
        if (const auto watched = interfaces_.start(); !watched) log_warning("{}", watched.error());
        stream_.start();
        channel_.start();
        ticker_.start(50ms);
        seconds_.start(1s);
        notify_systemd("READY=1", {}, Patience::some);
        if (const auto interval = watchdog_interval()) watchdog_.start(*interval);
        io_.run();
    }

    // Others notice at once that the topics end.
    void leave() { bus_->close(leave_patience); }

private:
    void wait_for_signal() {
        signals_.async_wait([this](error_code ec, int signal) {
            if (ec) return;
            log_info("stopping ({})", signal == SIGTERM ? "SIGTERM" : "SIGINT");
            io_.stop();
        });
    }

    // Joins the network, or waits for an address. Called after changes, and every second.
    void join() {
        const auto addresses = interface_addresses(settings_.interfaces);
        if (addresses.empty() || (joined_ && !must_rejoin(*joined_, addresses))) {
            if (!joined_ && !std::exchange(told_absent_, true))
                log_warning("no address on {}; waiting for it", interface_names());
            return;
        }
        std::vector<std::string> named;
        std::string shown;
        for (const auto& [index, address] : addresses) {
            if (!settings_.interfaces.empty()) named.push_back(address);
            shown += (shown.empty() ? "" : ", ") + address;
        }
        const bool is_change = joined_.has_value();
        joined_.reset();
        if (const std::string error = bus_->open(named); !error.empty()) {
            if (std::exchange(join_fault_, error) != error) log_warning("{}; trying again", printable(error));
            return;
        }
        log_info("{} {}", is_change ? "addresses changed; topics are on" : "topics are on", shown);
        join_fault_.clear();
        joined_ = addresses;
    }

    std::string interface_names() const {
        std::string names;
        for (const std::string& name : settings_.interfaces) names += (names.empty() ? "" : ", ") + name;
        return names.empty() ? "any interface" : names;
    }

    void every_second() {
        join();    // again, or because a change was not reported
        bridge_.publish_diagnostics(gateway_fault_, now_ns(), Clock::now());
        if (stream_.is_open() && bridge_.needs_names() && !std::exchange(asks_, true))
            requests_.ask("GET", "/devices", "", request_patience, [this](const http::Outcome& outcome) {
                asks_ = false;
                bridge_.use(devices_in(outcome.answer.body));
            });
    }

    // The gateway learns our address by it, and shows our name.
    void introduce(std::uint8_t to) {
        ano::Draft<"device_info"> draft;
        if (!draft.set<"dev_id">(ano::address::ros_bridge) || !draft.set<"name">(program_name)) return;
        std::array<std::uint8_t, 64> frame{};
        const std::size_t size = draft.encode(frame, ano::address::ros_bridge, to);
        channel_.send({frame.data(), size});
    }

    void on_channel_frame(ano::FrameView frame) {
        const auto question = ano::as<"parameter_command">(frame);
        const bool is_for_us = frame.destination() == ano::address::ros_bridge || frame.destination() == ano::address::broadcast;
        if (question && is_for_us && question->get<"cmd">() == 0) introduce(frame.source());
    }

    void on_closed(const std::string& why) {
        gateway_fault_ = printable(why);
        log_warning("{}; connecting again", gateway_fault_);
    }

    void on_opened() {
        gateway_fault_.clear();
        log_info("connected to the gateway");
    }

    // In a thread of the DDS library.
    void receive_sample(Sample sample) {
        if (++samples_ > max_samples) {
            --samples_;
            return;
        }
        asio::post(io_, [this, sample = std::move(sample)] {
            --samples_;
            bridge_.on_sample(sample, Clock::now());
        });
    }

    // In the thread of the DDS library that logs.
    void log_dds(const std::string& text) {
        if (const std::string line = dds_errors_.limited(printable(text), Clock::now()); !line.empty())
            log_warning("DDS: {}", line);
    }

    bool send(ano::Bytes frame) override { return channel_.send(frame); }
    bool call(std::uint8_t address, const CommandText& command, std::function<void(const http::Outcome&)> done) override {
        return requests_.ask(
            "POST",
            "/devices/" + ano::hex_byte(address) + "/commands/" + http::percent_encoded(command.command) + "?while_connected",
            command.body, command_patience, std::move(done));
    }
    void log(std::string_view line) override { log_info("{}", printable(std::string{line})); }
    void warn(std::string_view line) override { log_warning("{}", printable(std::string{line}, 400)); }

    const Ros2CommandLine& line_;
    const Ros2Settings& settings_;
    asio::io_context io_{1};
    asio::signal_set signals_{io_, SIGTERM, SIGINT};
    std::atomic<int> samples_{0};
    LineLimit dds_errors_;
    std::unique_ptr<NetworkBus> bus_;
    Bridge bridge_;
    std::optional<std::set<InterfaceAddress>> joined_;    // the addresses with which the network was joined
    bool told_absent_ = false, asks_ = false;
    std::string join_fault_;    // logged last; empty: none since the network was joined
    std::string gateway_fault_ = "not connected yet";
    InterfaceWatch interfaces_{io_, [this] { join(); }};
    GatewayRequests requests_{io_, settings_.control, program_name};
    GatewayChannel channel_{io_,
                            settings_.control,
                            "ros2",
                            {.opened = [this] { introduce(ano::address::host); },
                             .frame = [this](ano::FrameView frame) { on_channel_frame(frame); }}};
    FrameStream stream_{io_,
                        settings_.control,
                        filters,
                        {.frame = [this](const StreamedFrame& frame) { bridge_.receive(frame.link, frame.record, Clock::now()); },
                         .decoding = [this](const DecodingPtr& decoding) { bridge_.use(decoding); },
                         .lost = [this](std::uint64_t count) { bridge_.on_lost(count); },
                         .opened = [this] { on_opened(); },
                         .closed = [this](const std::string& why) { on_closed(why); }}};
    Ticker ticker_{io_, [this] { bridge_.on_time(Clock::now()); }};
    Ticker seconds_{io_, [this] { every_second(); }};
    Ticker watchdog_{io_, [] { notify_systemd("WATCHDOG=1"); }};
};

}    // namespace

int run_ros2(int argc, char** argv) {
    const auto parsed = parse_ros2_command_line(argc, argv);
    if (const auto* exit = std::get_if<Ros2Exit>(&parsed)) {
        (exit->code == 0 ? std::cout : std::cerr) << exit->text;
        return exit->code;
    }
    const auto& line = std::get<Ros2CommandLine>(parsed);
    if (line.print_config) std::cout << print_ros2_config(line.settings);
    if (line.check || line.print_config) return 0;
    std::signal(SIGPIPE, SIG_IGN);
    if (line.list) return TopicLister{line.settings}.run();
    start_log(line.settings.log);
    Ros2Program program{line};
    program.run();
    program.leave();
    end_log();
    ::_exit(0);
}

}    // namespace anogate
