#include <client/frame_stream.hpp>
#include <client/gateway_channel.hpp>
#include <client/gateway_requests.hpp>
#include <log/log.hpp>
#include <log/log_line.hpp>
#include <mavlink/bridge.hpp>
#include <mavlink/command_line.hpp>
#include <mavlink/mavlink_config.hpp>
#include <mavlink/program.hpp>
#include <mavlink/station_links.hpp>
#include <sys/notify.hpp>
#include <sys/ticker.hpp>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iostream>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;
using ano::Clock;
using mavlink::MavlinkBridge;
using mavlink::StationLink;

constexpr char frame_filters[] = "&direction=in&elsewhere=no&batch=2ms";
constexpr char mavlink_name[] = "anogate-mavlink";
constexpr ano::Duration job_patience = 120s;

class MavlinkProgram final : mavlink::BridgeOutput {
public:
    MavlinkProgram(const MavlinkCommandLine& line, const std::optional<mavlink::SigningKey>& key)
        : line_{line}, settings_{line.settings}, bridge_{settings_, *this, Clock::now(), key} {}

    void run() {
        log_info("{} {} starts, {}", mavlink_name, ANOGATE_VERSION,
                 line_.config_file.empty() ? "no configuration file" : line_.config_file);
        signals_.async_wait([this](error_code ec, int signal) {
            if (ec) return;
            log_info("stopping ({})", signal == SIGTERM ? "SIGTERM" : "SIGINT");
            io_.stop();
        });
        for (const std::string& place : settings_.udp) links_.push_back(make_udp(io_, bridge_, place));
        for (const std::string& place : settings_.udp_listen) links_.push_back(make_udp_listen(io_, bridge_, place));
        for (const std::string& place : settings_.tcp_listen) links_.push_back(make_tcp_listen(io_, bridge_, place));
        for (const std::string& device : settings_.serial) links_.push_back(make_serial(io_, bridge_, device, settings_.baud));
        stream_.start();
        channel_.start();
        ticker_.start(20ms);
        slow_ticker_.start(100ms);
        notify_systemd("READY=1", {}, Patience::some);
        if (const auto interval = watchdog_interval()) watchdog_.start(*interval);
        io_.run();
        links_.clear();
    }

private:
    // Frames arrive in batches: what is due is sent after the last of them, with its values.
    void on_frame(const StreamedFrame& frame) {
        bridge_.receive(frame.link, frame.record, Clock::now());
        if (std::exchange(is_posted_, true)) return;
        asio::post(io_, [this] {
            is_posted_ = false;
            bridge_.on_time(Clock::now());
        });
    }

    bool transmit(std::size_t connection, std::span<const std::uint8_t> packet) override {
        bool accepted = true;
        for (const auto& link : links_)
            if (link->transmit(connection, packet, accepted)) return accepted;
        return true;    // it was closed
    }
    bool send(ano::Bytes frame) override { return channel_.send(frame); }
    bool request(mavlink::DeviceRequest request, std::function<void(const http::Outcome&)> done) override {
        return requests_.ask(std::move(request.method), std::move(request.target), std::move(request.body), job_patience,
                             std::move(done));
    }
    void log(std::string_view line) override { log_info("{}", printable(std::string{line})); }
    std::uint64_t unix_us() override {
        return static_cast<std::uint64_t>(
            std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch()).count());
    }

    const MavlinkCommandLine& line_;
    const MavlinkSettings& settings_;
    asio::io_context io_{1};
    asio::signal_set signals_{io_, SIGTERM, SIGINT};
    MavlinkBridge bridge_;
    std::vector<std::unique_ptr<StationLink>> links_;
    bool is_posted_ = false;
    GatewayRequests requests_{io_, settings_.control, mavlink_name};
    GatewayChannel channel_{io_, settings_.control, "mavlink", {}};
    FrameStream stream_{io_,
                        settings_.control,
                        frame_filters,
                        {.frame = [this](const StreamedFrame& frame) { on_frame(frame); },
                         .decoding = [this](const DecodingPtr& decoding) { bridge_.use(decoding); },
                         .opened = [] { log_info("connected to the gateway"); },
                         .closed = [](const std::string& why) { log_warning("{}; connecting again", printable(why)); }}};
    Ticker ticker_{io_, [this] { bridge_.on_time(Clock::now()); }};
    Ticker slow_ticker_{io_, [this] {
                            for (const auto& link : links_) link->on_time(Clock::now());
                        }};
    Ticker watchdog_{io_, [] { notify_systemd("WATCHDOG=1"); }};
};

}    // namespace

namespace {

// False: the file can't be read, or its first line is empty.
bool read_key(const std::string& file, std::optional<mavlink::SigningKey>& key) {
    if (file.empty()) return true;
    std::ifstream input{file};
    std::string passphrase;
    if (!std::getline(input, passphrase) || passphrase.empty()) return false;
    key = mavlink::key_of_passphrase(passphrase);
    return true;
}

}    // namespace

int run_mavlink(int argc, char** argv) {
    const auto parsed = parse_mavlink_command_line(argc, argv);
    if (const auto* exit = std::get_if<MavlinkExit>(&parsed)) {
        (exit->code == 0 ? std::cout : std::cerr) << exit->text;
        return exit->code;
    }
    const auto& line = std::get<MavlinkCommandLine>(parsed);
    if (line.print_config) std::cout << print_mavlink_config(line.settings);
    std::optional<mavlink::SigningKey> key;
    if (!line.print_config && !read_key(line.settings.signing_file, key)) {
        std::cerr << mavlink_name << ": signing_file: " << line.settings.signing_file << " has no passphrase in its first line\n";
        return exit_config;
    }
    if (line.check || line.print_config) return 0;
    std::signal(SIGPIPE, SIG_IGN);
    start_log(line.settings.log);
    MavlinkProgram{line, key}.run();
    end_log();
    return 0;
}

}    // namespace anogate
