#include "device_client.hpp"

#include "device_access.hpp"
#include "device_names.hpp"
#include "file_text.hpp"
#include "job_text.hpp"
#include "link_access.hpp"

#include <ano/hex.hpp>
#include <ano_json/text.hpp>
#include <anoctl/own_link.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <http/asio.hpp>

#include <nlohmann/json.hpp>

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>
#include <variant>

namespace anoctl {

namespace asio = anogate::asio;
namespace http = anogate::http;
using ano::Json;
using anogate::error_code;

namespace {

http::Request request_of(const std::string& method, std::string target, std::string body) {
    http::Request request;
    request.method = method;
    request.target = std::move(target);
    request.body = std::move(body);
    return request;
}

// " --control PATH" for a command to suggest, if the option was given for the current one.
std::string place_to_type(const DeviceOptions& options) {
    const std::string& path = options.gateway.control;
    const bool is_plain = path.find_first_of(" \t'\"\\$*?;&|<>()") == std::string::npos;
    return path.empty() ? path : " --control " + (is_plain ? path : ano::in_quotes(path));
}

// The text of a refusal. If another client's job uses the device, also says how to follow or cancel that job.
std::string format_refusal(const http::Answer& answer, const Json& device, const DeviceOptions& options) {
    std::string words = with_device_named(with_options_named(format_failure(answer), options.command), device);
    const Json json = Json::parse(answer.body, nullptr, false);
    const std::string job = answer.status == 409 ? text_at(json, "job") : "", place = place_to_type(options);
    if (!job.empty())
        words += "; anoctl devices --jobs" + place + " shows its progress, anoctl devices --cancel " + job + place +
                 " cancels it";
    return words;
}

}    // namespace

struct DeviceClient::Loop {
    asio::io_context io{1};
    std::unique_ptr<DeviceAccess> access;
    Json device;    // null: not chosen yet
};

// Runs one job, from the request to its end.
class DeviceClient::Exchange {
public:
    Exchange(Loop& loop, Streams& streams, JobView& view, const DeviceOptions& options)
        : loop_{loop}, streams_{streams}, view_{view}, options_{options} {}

    Json run(http::Request request) {
        request.headers.push_back({"Accept", "application/x-ndjson"});
        request.target += request.target.find('?') == std::string::npos ? "?while_connected" : "&while_connected";
        loop_.io.restart();
        await_signal();
        begin(std::move(request));
        loop_.io.run();
        loop_.access->hang_up();
        signals_.cancel();
        view_.end();
        return result();
    }

private:
    void begin(http::Request request) {
        loop_.access->stream(
            std::move(request), [this](std::string_view line) { receive(line); },
            [this](http::Outcome outcome) {
                // Firmware and calibration: the response describes the job, which is then followed by a second request.
                if (outcome.fault.empty() && outcome.answer.status == 202 && !has_job_) {
                    receive(outcome.answer.body);
                    http::Request follow = request_of("GET", "/jobs/" + text_at(job_, "id") + "?while_connected", {});
                    follow.headers.push_back({"Accept", "application/x-ndjson"});
                    return begin(std::move(follow));
                }
                outcome_ = std::move(outcome);
                loop_.io.stop();
            });
    }

    void receive(std::string_view line) {
        Json job = Json::parse(line, nullptr, false);
        if (!job.is_object()) return;
        const std::string state = text_at(job, "state");
        job_ = std::move(job);
        has_job_ = true;
        if (state != "running" && state != "waiting") return;
        view_.show(job_);
        waits_ = state == "waiting";
        if (waits_ && view_.continues_unattended()) go_on();
        else if (waits_) await_key();
    }

    void go_on() {
        if (!std::exchange(waits_, false)) return;
        loop_.access->ask(request_of("POST", "/jobs/" + text_at(job_, "id") + "/next", {}), [](const http::Outcome&) {});
    }

    // Enter continues a waiting job.
    void await_key() {
        if (!streams_.in_is_terminal || keys_.is_open()) return;
        error_code ec;
        keys_.assign(::open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC), ec);    // not shared: Asio makes it non-blocking
        if (!ec) read_key();
    }
    void read_key() {
        keys_.async_read_some(asio::buffer(typed_), [this](error_code ec, std::size_t size) {
            if (ec) return;
            const auto end = typed_.begin() + static_cast<std::ptrdiff_t>(size);
            view_.went_down(static_cast<std::size_t>(std::count(typed_.begin(), end, '\n')));
            go_on();
            read_key();
        });
    }

    // The first signal cancels the job and waits for its end; the second one exits at once.
    void await_signal() {
        signals_.async_wait([this](error_code ec, int) {
            if (ec) return;
            if (std::exchange(interrupted_, true) || !has_job_) return loop_.io.stop();
            view_.end();
            streams_.err << "\nanoctl: cancelling the operation on the device; press Ctrl-C again to quit without waiting"
                         << std::endl;
            loop_.access->ask(request_of("DELETE", "/jobs/" + text_at(job_, "id"), {}), [](const http::Outcome&) {});
            await_signal();
        });
    }

    Json result() {
        const std::string state = text_at(job_, "state");
        const std::string error = with_device_named(with_options_named(text_at(job_, "error"), options_.command), loop_.device);
        if (state == "done" && job_.contains("result")) return std::move(job_["result"]);
        if (interrupted_ || !outcome_) {
            const std::string end = error.starts_with("cancelled") ? error : "cancelled";
            throw Interrupted{end + what_is_half_done()};
        }
        if (const std::string rest = half_done(job_); error.starts_with(gateway_ends))
            throw Failure{"the gateway stopped" + (rest.empty() ? error.substr(gateway_ends.size()) : ": " + rest)};
        const bool is_over = state != "running" && state != "waiting";
        if (has_job_ && !is_over && outcome_->answer.status / 100 != 4)
            throw Failure{"the gateway stopped; outcome unknown" + what_is_half_done()};
        if (!error.empty() && job_.contains("result")) throw JobFailure{error, job_["result"].dump()};
        if (state == "cancelled") throw Failure{"cancelled by another client" + what_is_half_done()};
        const bool is_counted = text_at(job_, "kind") == "put_waypoints" && number_at(job_, "total") > 0;
        if (text_at(job_, "what") == Outdated::what_of_commands) throw Outdated{error};
        if (!error.empty()) throw Failure{error + (is_counted ? what_is_half_done() : "")};
        if (!outcome_->fault.empty()) throw Failure{outcome_->fault};
        if (const http::Answer& answer = outcome_->answer; answer.status / 100 != 2) {
            const std::string words = format_refusal(answer, loop_.device, options_);
            const Json refusal = Json::parse(answer.body, nullptr, false);
            if (text_at(refusal, "what") == Outdated::what_of_commands) throw Outdated{words};
            throw Failure{words};
        }
        if (has_job_) throw Failure{"the job ended without reporting a result"};
        return parse_answer(outcome_->answer.body);
    }
    std::string what_is_half_done() const {
        const std::string rest = half_done(job_), error = text_at(job_, "error");
        if (!rest.empty()) return ": " + rest;
        return error.empty() || error.starts_with("cancelled") ? rest : ": " + error;
    }
    static constexpr std::string_view gateway_ends =
        "the gateway is stopping";    // beginning of the errors of a gateway that stops

    Loop& loop_;
    Streams& streams_;
    JobView& view_;
    const DeviceOptions& options_;
    asio::signal_set signals_{loop_.io, SIGINT, SIGTERM};
    asio::posix::stream_descriptor keys_{loop_.io};
    Json job_;
    bool has_job_ = false, waits_ = false, interrupted_ = false;
    std::array<char, 64> typed_{};
    std::optional<http::Outcome> outcome_;
};

void DeviceOptions::add(Options& declared, DeviceOptions& self, const char* command) {
    declared.push_back({"--device", &self.device, "DEVICE", "Device, by address or name (default: the only device)"});
    add_place(declared, self, command);
}

void DeviceOptions::add_place(Options& declared, DeviceOptions& self, const char* command) {
    self.command = command;
    declared.push_back(
        {"--link", &self.link, "KIND:ADDRESS[,KEY=VALUE...]", "Use this link, as for anogated, instead of a gateway"});
    GatewayOptions::add(declared, self.gateway);
    declared.push_back({"--json", &self.json, "", "Print one JSON object per line"});
}

void DeviceOptions::add_yes(Options& declared, DeviceOptions& self) {
    declared.push_back({"--yes", &self.yes, "", "Run without confirmation"});
}

DeviceClient::DeviceClient(const DeviceOptions& options, Streams& streams)
    : options_{options}, streams_{streams}, loop_{std::make_unique<Loop>()} {
    if (options.link.empty()) {
        loop_->access = gateway_access(loop_->io, options.gateway.socket());
        return;
    }
    const auto called = ano::address_called(options.device);
    const auto* const address = std::get_if<std::uint8_t>(&called);
    const auto there = options.asks_nothing_first && address != nullptr ? std::optional{*address} : std::nullopt;
    if (there) loop_->device = Json{{"address", ano::hex_byte(*there)}};
    loop_->access = link_access(loop_->io, link_settings_of(options.link), streams, there);
}
DeviceClient::~DeviceClient() = default;

Json DeviceClient::ask(const std::string& method, const std::string& target, std::string body) {
    std::optional<http::Outcome> outcome;
    loop_->io.restart();
    loop_->access->ask(request_of(method, target, std::move(body)), [&](http::Outcome came) {
        outcome = std::move(came);
        loop_->io.stop();
    });
    loop_->io.run();
    if (!outcome) throw Failure{"no response"};
    if (!outcome->fault.empty()) throw Failure{outcome->fault};
    if (outcome->answer.status / 100 != 2) throw Failure{format_refusal(outcome->answer, loop_->device, options_)};
    return parse_answer(outcome->answer.body);
}

Json DeviceClient::run(http::Request request, JobView& view) {
    if (acts_) request.target += request.target.find('?') == std::string::npos ? "?to_act" : "&to_act";
    return Exchange{*loop_, streams_, view, options_}.run(std::move(request));
}

Json DeviceClient::run(const std::string& method, const std::string& target, std::string body) {
    ProgressView view{streams_, false};
    return run(request_of(method, target, std::move(body)), view);
}

Json DeviceClient::device_list(bool scan) { return scan ? run("POST", "/devices/scan", "{}") : ask("GET", "/devices"); }

Json DeviceClient::devices(bool scan) { return at(device_list(scan), "devices"); }

const Json& DeviceClient::device() {
    if (!loop_->device.is_null()) return loop_->device;
    // A link of this process has not received any frame yet, so a scan is needed.
    Json found = choose(devices(!options_.link.empty()));
    if (found.empty() && options_.link.empty()) found = choose(devices(true));
    if (found.size() > 1 && !all_have_names(found)) found = choose(devices(true));    // so that the user can choose by name
    if (found.size() == 1) return loop_->device = found.front();
    if (found.size() > 1) throw UsageError{"several devices found; choose one with --device: " + list_of(found)};
    throw Failure{options_.device.empty() ? "no device responded" : no_such_device(options_.device, devices(false))};
}

Json DeviceClient::choose(const Json& found) const {
    if (options_.device.empty()) return found;
    Json named = with_name(found, options_.device);
    if (!named.empty()) return named;
    const auto address = ano::address_called(options_.device);
    const auto* number = std::get_if<std::uint8_t>(&address);
    if (number == nullptr) return named;
    for (const Json& device : found)
        if (text_at(device, "address") == ano::hex_byte(*number)) return Json::array({device});
    return Json::array({Json{{"address", ano::hex_byte(*number)}}});    // may respond even if no frame was received yet
}

const Json& DeviceClient::known_device() {
    if (device().contains("name")) return loop_->device;
    for (const Json& one : devices(true))
        if (text_at(one, "address") == text_at(loop_->device, "address")) loop_->device = one;
    return loop_->device;
}

std::string DeviceClient::target(const std::string& rest) { return "/devices/" + text_at(device(), "address") + rest; }

std::string DeviceClient::device_words() { return format_device(device()); }

void DeviceClient::must_be_able_to_ask(const std::string& what) const {
    if (!options_.yes && !streams_.in_is_terminal)
        throw UsageError{what + ": confirmation required, but stdin is not a terminal; use --yes"};
}

bool DeviceClient::may(const std::string& question) {
    if (options_.yes) return true;
    must_be_able_to_ask("this command");
    return agrees(streams_, question);
}

bool DeviceClient::may_write(const std::string& path) {
    if (!is_file(path) || options_.yes) return true;
    if (!streams_.in_is_terminal) throw UsageError{path + " already exists; use --yes to replace it"};
    return may(path + " already exists. Replace it?");
}

}    // namespace anoctl
