// anoctl status: the state of the gateway.
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"

#include <ano_json/escapes.hpp>
#include <nlohmann/json.hpp>

#include <ano_json/text.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>
#include <ostream>
#include <string>
#include <thread>
#include <utility>

namespace anoctl {
namespace {

using ano::Json;

std::string first_line(const Json& gateway) {
    std::string line = text_at(gateway, "name") + ", anogate " + text_at(gateway, "version");
    if (const std::string id = text_at(gateway, "id"); !id.empty()) line += ", id " + id;
    line += ", up for " + time_text(number_at(gateway, "uptime_s"));
    if (const std::string stood = text_at(gateway, "standstills"); !stood.empty() && stood != "0")
        line += "; stalled " + stood + " times, up to " + time_text(number_at(gateway, "longest_standstill_s"));
    return line;
}

std::string sum_of(const Json& link, const std::vector<std::string>& names) {
    double sum = 0;
    for (const std::string& name : names) sum += number_at(link, name);
    return Json(static_cast<std::uint64_t>(sum)).dump();
}

// Frames per second between two responses. Empty: the link was missing in the earlier one, or was recreated.
std::string rate_of(const Json& link, const char* counter, const Json& before, double seconds) {
    for (const Json& one : before) {
        if (text_at(one, "name") != text_at(link, "name") || seconds <= 0) continue;
        const double frames = number_at(link, counter) - number_at(one, counter);
        return frames < 0 ? std::string{} : ano::number_text(std::round(frames / seconds));
    }
    return {};
}

// `before`: the links `seconds` ago. A hint that several links have is printed once, for the first of them.
void write_links(const Json& links, const Json& before, double seconds, std::ostream& out) {
    Table table{{"LINK", "KIND", "STATE", "SINCE", " IN/s", " OUT/s", " IN", " OUT", " DROPPED"}};
    PrintedHints printed;
    for (const Json& link : links) {
        table.row({text_at(link, "name"), text_at(link, "kind"), text_at(link, "state"), time_text(number_at(link, "since_s")),
                   rate_of(link, "frames_in", before, seconds), rate_of(link, "frames_out", before, seconds),
                   text_at(link, "frames_in"), text_at(link, "frames_out"), sum_of(link, drop_causes(is_alone(link)))});
        if (const std::string place = listening_place(link); !place.empty()) table.note("    at " + place);
        for (const char* key : {"error", "hint"})
            if (const std::string words = printed.once(key, text_at(link, key)); !words.empty()) table.note("    " + words);
    }
    if (table.empty()) out << "no links are configured\n";
    else table.write(out);
}

void write_conflicts(const Json& conflicts, std::ostream& out) {
    for (const Json& conflict : conflicts)
        out << "conflict: " << text_at(conflict, "address") << " is received on " << names_at(conflict, "links") << ", "
            << text_at(conflict, "count") << " times\n";
}

void write_lost(const Json& all, std::ostream& out) {
    for (const Json& lost : all) {
        const std::string name = text_at(lost, "name");
        out << "lost: " << text_at(lost, "address") << (name.empty() ? "" : " " + name) << ", " << lost_text(lost) << '\n';
    }
}

void write_http(const Json& http, std::ostream& out) {
    for (const char* what : {"error", "hint"})
        if (const std::string text = text_at(http, what); !text.empty()) out << list_text("http: ", {text}) << '\n';
}

void write_tunnel(const Json& tunnel, std::ostream& out) {
    std::vector<std::string> names;
    for (const auto& [name, value] : tunnel.items()) names.push_back(name);
    if (!names.empty()) out << list_text("tunnel: ", not_zero(tunnel, names)) << '\n';
}

void write_gpio(const Json& lines, std::ostream& out) {
    for (const Json& line : lines) {
        out << "gpio: " << text_at(line, "use") << ", " << text_at(line, "chip") << " line " << text_at(line, "line") << ": ";
        const std::string error = text_at(line, "error"), value = text_at(line, "value");
        out << text_at(line, "state") << (error.empty() ? "" : ", " + error)
            << (value.empty()     ? ""
                : value == "true" ? ", active"
                                  : ", inactive")
            << '\n';
    }
}

struct Verdict {
    bool is_ok = true;
    std::string text = "ok";
};

// Hints of what works: a host may only receive, or connect later; a certificate is valid until it expires.
bool is_calm(const std::string& hint) {
    return hint == "no_host_takes" || hint == "no_peer_yet" || hint == "clients_without_frame" || hint == "recording_ended" ||
           hint == "certificate_expires";
}

// Degraded: vehicles lost while unlocked, links that are down, have an expired or unusable certificate or a hint, conflicts of addresses,
// recordings that fail, an HTTP interface that is off or has an expired certificate or a hint.
Verdict verdict_of(const Json& status) {
    const Json& http = at(status, "http");
    const std::string http_hint = text_at(http, "hint_id");
    std::size_t links = 0, down = 0, unusable = 0, expired = number_at(http, "certificate_days") < 0 ? 1 : 0,
                hints = http_hint.empty() || is_calm(http_hint) ? 0 : 1;
    for (const Json& link : at(status, "links")) {
        if (text_at(link, "error_id") == "disabled") continue;
        ++links;
        const bool is_up = text_at(link, "state") == "up";
        down += is_up ? 0u : 1u;
        expired += number_at(link, "certificate_days") < 0 ? 1u : 0u;
        const std::string hint = text_at(link, "hint_id");
        hints += is_up && !hint.empty() && !is_calm(hint) ? 1u : 0u;
        unusable += text_at(link, "error_id") == "certificate_unusable" ? 1u : 0u;
    }
    std::string what;
    for (const Json& lost : at(status, "lost"))
        if (may_fly(lost)) what += (what.empty() ? "" : ", ") + text_at(lost, "address") + " lost, " + lost_text(lost);
    if (down > 0) what += (what.empty() ? "" : ", ") + std::to_string(down) + " of " + plural(links, "link");
    if (expired > 0) what += (what.empty() ? "" : ", ") + plural(expired, "expired certificate");
    if (const std::size_t conflicts = at(status, "conflicts").size(); conflicts > 0)
        what += (what.empty() ? "" : ", ") + plural(conflicts, "conflict");
    else if (hints > 0) what += (what.empty() ? "" : ", ") + plural(hints, "hint");
    if (unusable > 0) what += (what.empty() ? "" : ", ") + plural(unusable, "unusable certificate");
    if (!text_at(http, "error").empty()) what += (what.empty() ? "" : ", ") + std::string{"http"};
    const Json& running = at(at(status, "recording"), "running");
    if (std::any_of(running.begin(), running.end(), [](const Json& one) { return !text_at(one, "error").empty(); }))
        what += (what.empty() ? "" : ", ") + std::string{"recording"};
    return what.empty() ? Verdict{} : Verdict{false, "degraded: " + what};
}

struct StatusView {
    static constexpr auto between = std::chrono::milliseconds{500};    // between two responses, for the rates
    static constexpr int degraded = 3;                                 // the exit status
    GatewayOptions gateway;
    bool json = false, exit_code = false;

    int run(Streams& streams) const {
        Json status = parse_answer(gateway.ask("GET", "/status"));
        if (json) {
            streams.out << ano::json_text(status) << '\n';
            return exit_of(verdict_of(status));
        }
        const Json before = std::move(status);
        std::this_thread::sleep_for(between);
        status = parse_answer(gateway.ask("GET", "/status"));
        const Verdict verdict = verdict_of(status);
        const double seconds = number_at(at(status, "gateway"), "uptime_s") - number_at(at(before, "gateway"), "uptime_s");
        const char* const color = verdict.is_ok ? "\x1b[32m" : "\x1b[31m";
        streams.out << (streams.color ? color + verdict.text + "\x1b[0m" : verdict.text) << '\n';
        streams.out << first_line(at(status, "gateway")) << '\n';
        write_links(at(status, "links"), at(before, "links"), seconds, streams.out);
        write_lost(at(status, "lost"), streams.out);
        write_conflicts(at(status, "conflicts"), streams.out);
        write_http(at(status, "http"), streams.out);
        write_tunnel(at(status, "tunnel"), streams.out);
        write_gpio(at(status, "gpio"), streams.out);
        for (const std::string& line : recording_lines(at(status, "recording"))) streams.out << line << '\n';
        return exit_of(verdict);
    }

private:
    int exit_of(const Verdict& verdict) const { return exit_code && !verdict.is_ok ? degraded : fine; }
};

}    // namespace

Run add_status(Options& options) {
    const auto self = std::make_shared<StatusView>();
    GatewayOptions::add(options, self->gateway);
    options.push_back(
        {"--exit-code", &self->exit_code, "",
         "Exit with status 3 if the gateway is degraded: a vehicle that was not locked is lost, a link is down, has "
         "an expired or unusable certificate, or has a hint that asks for an action, two devices use the same address, or a "
         "recording or "
         "the HTTP interface fails"});
    options.push_back({"--json", &self->json, "", "Print the response of the gateway as one JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
