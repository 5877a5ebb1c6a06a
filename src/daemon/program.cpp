#include <config/config.hpp>
#include <control/control_listeners.hpp>
#include <control/flexible_control.hpp>
#include <control/raw_streams.hpp>
#include <control/recording_routes.hpp>
#include <control/reload_routes.hpp>
#include <control/routes.hpp>
#include <control/watch_session.hpp>
#include <daemon/command_line.hpp>
#include <daemon/first_line.hpp>
#include <daemon/program.hpp>
#include <foxglove/foxglove_streams.hpp>
#include <http/task_pool.hpp>
#include <link/udp/ip_socket.hpp>
#include <log/log.hpp>
#include <log/log_line.hpp>
#include <recording/recordings.hpp>
#include <runtime/gateway.hpp>
#include <runtime/gateway_devices.hpp>
#include <runtime/kept_parameters.hpp>
#include <runtime/own_device.hpp>
#include <runtime/reload.hpp>
#include <runtime/restart.hpp>
#include <status/status.hpp>
#include <sys/files/state_folder.hpp>
#include <sys/lazy_memory.hpp>
#include <sys/notify.hpp>
#include <sys/ticker.hpp>
#include <watch/frame_watch.hpp>

#include <csignal>
#include <initializer_list>
#include <iostream>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace anogate {
namespace {

constexpr Duration flush_patience = std::chrono::milliseconds{500};
constexpr Duration between_hints = std::chrono::seconds{3};

// Blocks or unblocks signals that would end the program before it can handle them.
void hold_signals(int how, std::initializer_list<int> signals) {
    sigset_t held;
    sigemptyset(&held);
    for (const int signal : signals) sigaddset(&held, signal);
    ::sigprocmask(how, &held, nullptr);
}

// Reading the configuration may take long, for example from a pipe without a writer, and no running part needs an orderly stop
// during that time. SIGINT has its default effect meanwhile.
void let_sigterm_end_at_once() {
    std::signal(SIGTERM, [](int) { ::_exit(0); });
}

// Opens closed standard files. Otherwise a device or a socket could get the number of a standard file, and messages to the user
// would be written to it.
void fill_standard_files() {
    int fd = 0;
    while (fd >= 0 && fd <= STDERR_FILENO) fd = ::open("/dev/null", O_RDWR);
    if (fd > STDERR_FILENO) ::close(fd);
}

std::string recordings_folder() {
    const std::string folder = state_folder();
    return folder.empty() ? folder : folder + "/recordings";
}

// The running program: the gateway, its control interface, and the handling of signals.
class Program final : private GatewayEvents {
public:
    Program(const CommandLine& line, const WrittenValues& written, const WrittenValues& kept,
            std::optional<KeptFlexible> kept_flexible, std::string source, ReadAgain read_again, ConfigState::Runs runs)
        : gateway_{io_, written.applied(line.settings)},
          source_{std::move(source)},
          reload_{io_, gateway_, {line.settings, line.files}, std::move(read_again), kept_config_path(line.config_file), written},
          own_device_{gateway_, reload_, kept_parameters_path(line.config_file), kept},
          flexible_{gateway_, kept_flexible_path(line.config_file), std::move(kept_flexible)},
          recordings_{gateway_, watch_, recordings_folder()},
          signals_{io_, SIGTERM, SIGINT, SIGHUP} {
        gateway_.parts().enter(*this);
        gateway_.set_config_state({line.config_file, runs});
        own_device_.keep_in_step();
        reload_.on_links_changed([this](const std::vector<std::string>& names) {
            for (const std::string& name : names) hint_log_.forget(name);
            recordings_.configure();
        });
        add_routes(
            control_.routes(), {gateway_, devices_.service(), frames_, foxglove_, raw_, map_disk_},
            [this] { return control_.listener_info(); }, installed_page());
        add_reload_routes(control_.routes(), reload_);
        add_recording_routes(control_.routes(), recordings_);
        flexible_.add_routes(control_.routes());
        flexible_.before_change([this] { recordings_.catch_up(); });
        control_.add_login_routes();
        reload_.on_reloaded([this](bool dry_run, const Reload::Reread& done) { control_.renew(dry_run, done); });
        signals_.add(SIGUSR1);
        hold_signals(SIG_UNBLOCK, {SIGTERM, SIGHUP, SIGUSR1});
    }

    int run() {
        log_info("{}", first_line(gateway_.settings(), source_, own_networks()));
        if (!control_.open()) return exit_config;
        wait_for_signal();
        if (gateway_.settings().links.empty()) log_warning("the configuration has no links, so no frames will be forwarded");
        gateway_.start(std::move(stored_));
        recordings_.start();
        notify_systemd("READY=1", {}, Patience::some);
        keep_watchdog();
        hints_.start(between_hints);
        io_.run();
        const FrameCount passed = frame_count(gateway_);
        log_info("{}", last_line(why_, gateway_.now() - gateway_.started_at(), passed.in, passed.out));
        hold_signals(SIG_BLOCK, {SIGTERM, SIGINT});    // another signal must not end the program while it waits for the log
        return status_;
    }

private:
    void required_missing(const std::string& link) override {
        log_error("required link {} was not up within 10 s", link);
        status_ = 1;
        stop("a required link is not up");
    }

    void stopping() override { map_disk_.stop(); }

    void closing(const ClockReading& unread_since) override { send_restart_state(gateway_, unread_since); }

    void wait_for_signal() {
        signals_.async_wait([this](error_code ec, int signal) {
            if (ec || stopped_) return;
            wait_for_signal();    // first, because a second stop() cancels all waits, including this one
            if (signal == SIGUSR1) log_asked("status\n" + status_text(gateway_));
            else if (signal == SIGHUP) reload_soon();
            else stop(signal == SIGTERM ? "SIGTERM" : "SIGINT");
        });
    }

    void reload_soon() {
        log_info("SIGHUP: reloading the configuration");
        reload_.reload_soon();
    }

    void keep_watchdog() {
        const auto interval = watchdog_interval();
        if (!interval) return;
        notify_systemd("WATCHDOG=1");
        watchdog_.start(*interval);
    }

    void log_hints() {
        for (const std::string& line : hint_log_.news(gateway_)) log_info("{}", line);
        control_.log_validity();
    }

    // A second signal while waiting frames are sent stops the program at once.
    void stop(const char* why) {
        const bool again = !why_.empty();
        if (!again) why_ = why;
        notify_systemd("STOPPING=1");
        watchdog_.stop();
        hints_.stop();
        reload_.stop();
        if (again) control_.close();
        gateway_.stop(flush_patience, [this] {
            stopped_ = true;
            recordings_.stop([this] { control_.no_more_answers(); });    // after the gateway, so that they contain all frames
            signals_.cancel();
        });
        if (!again) control_.finish(flush_patience);    // the jobs have ended: their followers receive the results
    }

    asio::io_context io_{1};
    Gateway gateway_;
    std::string source_;    // the source of the configuration
    std::string why_;       // the reason for the end
    Reload reload_;
    OwnDevice own_device_;
    GatewayDevices devices_{gateway_};
    FrameWatch watch_{gateway_};
    FrameStreams frames_{gateway_, watch_};
    FoxgloveStreams foxglove_{gateway_, watch_, devices_.service()};
    RawStreams raw_{gateway_};
    TaskPool map_disk_{io_};
    FlexibleControl flexible_;
    Recordings recordings_;
    ControlListeners control_{io_, gateway_.settings().control};
    asio::signal_set signals_;
    Ticker watchdog_{io_, [] { notify_systemd("WATCHDOG=1"); }};
    Ticker hints_{io_, [this] { log_hints(); }};
    HintLog hint_log_;
    RestartState stored_ = receive_restart_state();    // until the gateway starts
    bool stopped_ = false;                             // all parts have stopped: no more waits for signals
    int status_ = 0;
};

std::string source_of(const CommandLine& line) {
    if (line.config_file.empty()) return "command line";
    return line.config_file + (line.has_links ? " and command line" : "");
}

// If the file was not confirmed and has not changed since, a restart runs the previous configuration.
ConfigState::Runs apply_kept_config(CommandLine& line, int argc, char** argv) {
    const std::string path = kept_config_path(line.config_file);
    std::string fault;
    const auto kept = kept_config(path, fault);
    if (!fault.empty())
        print_lines(Priority::warning, "anogated: the configuration stored for a restart is not used: " + fault + "; running " +
                                           line.config_file + "\n");
    if (!kept) return ConfigState::Runs::file;
    if (!have_same_texts(kept->unconfirmed, line.files)) {
        forget_config(path);
        return ConfigState::Runs::file;
    }
    auto before = parse_command_line(argc, argv, default_config_file(), &kept->confirmed);
    if (const Exit* exit = std::get_if<Exit>(&before)) {
        print_lines(Priority::warning, exit->text + "anogated: running the unconfirmed " + line.config_file + "\n");
        return ConfigState::Runs::file;
    }
    line = std::get<CommandLine>(std::move(before));
    return ConfigState::Runs::not_the_file;
}

ReadAgain read_again(int argc, char** argv) {
    return [argc, argv]() -> std::variant<ReadConfig, ConfigErrors> {
        auto parsed = parse_command_line(argc, argv);
        if (Exit* exit = std::get_if<Exit>(&parsed)) return std::move(exit->faults);
        auto& line = std::get<CommandLine>(parsed);
        return ReadConfig{std::move(line.settings), std::move(line.files)};
    };
}

int output_failed() {
    print_lines(Priority::error, "anogated: cannot write the output\n");
    return 1;
}

int run(int argc, char** argv) {
    auto parsed = parse_command_line(argc, argv);
    if (const Exit* exit = std::get_if<Exit>(&parsed)) {
        if (exit->code != 0) print_lines(Priority::error, exit->text);
        else if (!(std::cout << exit->text << std::flush)) return output_failed();
        return exit->code;
    }
    CommandLine& line = std::get<CommandLine>(parsed);
    if (line.check) print_lines(Priority::warning, line.warnings);
    if (line.print_config && !(std::cout << print_config(line.settings) << std::flush)) return output_failed();
    if (line.check || line.print_config) return 0;
    hold_signals(SIG_BLOCK, {SIGTERM});
    std::signal(SIGPIPE, SIG_IGN);
    fill_standard_files();
    const ConfigState::Runs runs = line.config_file.empty() ? ConfigState::Runs::file : apply_kept_config(line, argc, argv);
    start_log(line.settings.log);
    WrittenValues kept;
    if (is_device(line.settings.gateway)) kept = kept_parameters(kept_parameters_path(line.config_file));
    WrittenValues written = kept;
    for (const std::string& key : written.forget_stale(line.settings))
        log_info("discarded the stored gateway parameter {}: the configuration changed after it was written", key);
    if (runs == ConfigState::Runs::not_the_file)
        log_warning("{} was not confirmed; running the previous configuration until the file changes or is reloaded",
                    line.config_file);
    if (!written.empty()) set_log_level(written.applied(line.settings).log.level);
    return Program{
        line, written, kept, kept_flexible(kept_flexible_path(line.config_file)), source_of(line), read_again(argc, argv), runs}
        .run();
}

}    // namespace

// Ends the program if the system refuses memory or the descriptors of the loop, because a retry would not help.
int run_program(int argc, char** argv) {
    map_lazy_arrays_separately();
    hold_signals(SIG_BLOCK, {SIGHUP, SIGUSR1});
    let_sigterm_end_at_once();
    int status = 1;
    try {
        status = run(argc, argv);
    } catch (const std::bad_alloc&) {
        print_lines(Priority::error, "anogated: out of memory\n");
    } catch (const std::exception& error) {
        print_lines(Priority::error, std::string{"anogated: "} + error.what() + "\n");
    }
    if (!end_log()) ::_exit(status);
    return status;
}

}    // namespace anogate
