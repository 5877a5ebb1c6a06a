// anoctl setup: sets up the service after the installation of the package, up to the open page. Each step asks first.
#include <anoctl/anoctl.hpp>
#include <anoctl/device/file_text.hpp>
#include <anoctl/gateway.hpp>
#include <anoctl/ports/detect_rate.hpp>
#include <anoctl/ports/port_list.hpp>
#include <anoctl/ports/ports.hpp>
#include <anoctl/run_program.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/web/sign_in.hpp>
#include "service_config.hpp"

#include <ano_json/text.hpp>
#include <sys/files/write_atomically.hpp>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t rate_of_the_vendor = 500000;
constexpr const char* url_of_page = "http://127.0.0.1:8088/";    // of service_config()

struct Setup {
    std::string port, file = "/etc/anogate/anogate.json";
    std::uint32_t baud = 0;
    std::uint8_t v7_device = 0;    // 0: it uses V8
    bool yes = false;
    GatewayOptions gateway{};    // the service

    int run(Streams& streams) {
        check(streams);
        if (port.empty()) port = chosen_port(streams);
        if (baud == 0) baud = detected_rate(streams);
        if (!write_config(streams) || !start_service(streams)) return failed;
        return show_page(streams);
    }

private:
    void check(const Streams& streams) const {
        if (!yes && !streams.in_is_terminal) throw UsageError{"confirmation required, but stdin is not a terminal; use --yes"};
        const fs::path folder = fs::path{file}.parent_path();
        if (!fs::is_directory(folder))
            throw Failure{"folder not found: " + folder.string() + "; install the package anogate first"};
        if (::access(folder.c_str(), W_OK) != 0)
            throw Failure{"permission denied: cannot write " + file + "; use sudo anoctl setup"};
    }

    bool may(Streams& streams, const std::string& question) const { return yes || agrees(streams, question); }

    std::string chosen_port(Streams& streams) const {
        const std::vector<SerialPort> ports = serial_ports("/", anogate::DeviceUser::this_process());
        write_ports("/", anogate::DeviceUser::this_process(), false, streams.out);
        if (ports.empty())
            throw Failure{"no serial port found; plug the device in and repeat, or give a port: anoctl setup PORT"};
        if (ports.size() == 1 && may(streams, "Use " + ports[0].device + "?")) return lasting_name(ports[0]);
        if (yes)
            throw UsageError{"several serial ports found; choose one, for example: anoctl setup " + ports[0].device + " --yes"};
        for (;;) {
            ask_for(streams, "Which port?");
            const std::string wanted = answer(streams);
            if (wanted.empty()) throw Failure{"no port selected; nothing was changed"};
            for (const SerialPort& one : ports)
                if (one.device == wanted || one.stable == wanted || one.device == "/dev/" + wanted) return lasting_name(one);
            print_note(streams, "no port " + ano::in_quotes(wanted) + " in the list above");
        }
    }
    static std::string lasting_name(const SerialPort& port) { return port.stable.empty() ? port.device : port.stable; }
    static void ask_for(Streams& streams, const std::string& question) { streams.err << question << ' ' << std::flush; }

    /// Returns the baud rate; 0: the port ignores it.
    std::uint32_t detected_rate(Streams& streams) {
        if (!may(streams, "Listen at " + port + " to find the baud rate? This takes up to 20 s and sends nothing."))
            return rate_of_the_vendor;
        try {
            const FoundRate found = find_rate(port, streams);
            print(streams, port + (found.any_rate ? ": any baud rate works" : ": " + std::to_string(found.baud) + " baud") +
                               (found.v7_device == 0 ? "" : ", protocol V7"));
            v7_device = found.v7_device;
            return found.any_rate ? 0 : found.baud;
        } catch (const Failure& nothing) {
            print_note(streams, nothing.what());
            if (!may(streams,
                     "Continue with " + std::to_string(rate_of_the_vendor) + " baud? Some devices send only after a hello."))
                throw Failure{"nothing was changed"};
            return rate_of_the_vendor;
        }
    }

    bool write_config(Streams& streams) const {
        const std::string text = service_config(port, baud, v7_device);
        streams.out << text;
        const bool is_there = is_file(file);
        if (!may(streams, "Write this to " + file + "?" + (is_there ? " The existing file is kept as " + file + ".old." : "")))
            return false;
        std::error_code ec;
        if (is_there) fs::rename(file, file + ".old", ec);
        if (ec) throw Failure{file + ".old: " + ec.message()};
        const std::string wrong = anogate::write_atomically(file,
                                                            {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        if (!wrong.empty()) throw Failure{wrong};
        fs::permissions(file, fs::perms{0644}, ec);
        print(streams, file + " written");
        return true;
    }

    bool start_service(Streams& streams) const {
        if (!may(streams, "Enable and start the service now?")) {
            print(streams, "to start it later: sudo systemctl enable --now anogated");
            return false;
        }
        for (const std::vector<std::string>& words :
             {std::vector<std::string>{"systemctl", "enable", "anogated"}, {"systemctl", "restart", "anogated"}}) {
            streams.out.flush();
            const auto status = run_program(words);
            if (!status)
                throw Failure{"systemctl is not installed; without systemd, start the gateway with: anogated --config " + file};
            if (*status != 0) throw Failure{"systemctl " + words[1] + " failed; for the reason: journalctl -u anogated"};
        }
        return true;
    }

    int show_page(Streams& streams) const {
        const auto is_set = [](const char* name) {
            const char* const value = std::getenv(name);
            return value != nullptr && *value != '\0';
        };
        const bool has_screen = is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
        print(streams, std::string{"Page: "} + url_of_page);
        print(streams, "To sign in: sudo anoctl web --open, or sudo anoctl web --pair for a code to type");
        print(streams, "Status: sudo anoctl status");
        if (!has_screen || !may(streams, "Open the page?")) return fine;
        try {
            await_page();
            streams.out.flush();
            SignIn{gateway, false}.open(url_of_page);
        } catch (const Failure& failure) {
            print_note(streams, failure.what());
        }
        return fine;
    }

    /// Waits until the service, which was just started, serves the page. Throws Failure after 10 s.
    void await_page() const {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{10};
        for (;; std::this_thread::sleep_for(std::chrono::milliseconds{200})) {
            const bool is_over = std::chrono::steady_clock::now() >= end;
            try {
                if (text_at(at(parse_answer(gateway.ask("GET", "/status")), "http"), "state") == "up") return;
            } catch (const Failure&) {
                if (is_over) throw;
            }
            if (is_over) throw Failure{"the gateway does not serve the page; for the reason: journalctl -u anogated"};
        }
    }
};

}    // namespace

Run add_setup(Options& options) {
    const auto self = std::make_shared<Setup>();
    options.push_back({"port", &self->port, "PORT", "Serial port of the device (default: the only one, or the one you select)"});
    options.push_back({"--baud",
                       [self](const std::string& word) {
                           const char* const end = word.data() + word.size();
                           const auto [last, wrong] = std::from_chars(word.data(), end, self->baud);
                           const bool is_rate = wrong == std::errc{} && last == end && self->baud > 0;
                           return is_rate ? std::string{} : ano::in_quotes(word) + " is not a baud rate";
                       },
                       "N", "Baud rate of the device (default: detected by listening)"});
    options.push_back({"--into", &self->file, "FILE", "Configuration file to write (default: /etc/anogate/anogate.json)"});
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--yes", &self->yes, "", "Run each step without confirmation"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
