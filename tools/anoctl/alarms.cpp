// anoctl alarms: the values of devices that exceed their limits, as evaluated by the gateway.
#include <anoctl/text/frame_printer.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/text.hpp>
#include <http/client/client.hpp>
#include <sys/asio.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

namespace asio = anogate::asio;
namespace http = anogate::http;
using ano::Json;

std::string short_number(double value) {
    char text[32];
    return {text, static_cast<std::size_t>(std::snprintf(text, sizeof text, "%.6g", value))};
}

std::string in_unit(const Json& alarm, std::string_view key) {
    const std::string unit = text_at(alarm, "unit");
    return short_number(number_at(alarm, key)) + (unit.empty() ? "" : " " + unit);
}
std::string judged_text(const Json& alarm) {
    return in_unit(alarm, "value") + (text_at(alarm, "cells").empty() ? "" : " per cell");
}
std::string limit_text(const Json& alarm) { return text_at(alarm, "side") + " " + in_unit(alarm, "limit"); }
std::string device_text(const Json& alarm) {
    const std::string name = text_at(alarm, "name");
    return text_at(alarm, "device") + (name.empty() ? "" : " " + name);
}

/// Prints the differences between successive responses of the gateway.
class ChangePrinter {
public:
    explicit ChangePrinter(Streams& streams) : streams_{streams} {}

    void print(const std::vector<Json>& alarms) {
        std::map<std::string, Json> now;
        for (const Json& alarm : alarms) now.emplace(key_of(alarm), alarm);
        for (const auto& [key, alarm] : now) {
            const auto before = before_.find(key);
            if (before == before_.end() || text_at(before->second, "level") != text_at(alarm, "level"))
                line(alarm, text_at(alarm, "level"), judged_text(alarm) + ", " + limit_text(alarm));
        }
        for (const auto& [key, alarm] : before_)
            if (!now.contains(key)) line(alarm, "ended", "");
        before_ = std::move(now);
        streams_.out.flush();
    }

private:
    static std::string key_of(const Json& alarm) {
        return text_at(alarm, "device") + " " + text_at(alarm, "field") + " " + text_at(alarm, "side");
    }
    void line(const Json& alarm, const std::string& what, const std::string& values) {
        const char* const color = what == "red" ? "\x1b[31m" : what == "amber" ? "\x1b[33m" : "\x1b[32m";
        const double time = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
        streams_.out << clock_text(time) << ' ' << device_text(alarm) << ' ' << (streams_.color ? color + what + "\x1b[0m" : what)
                     << ' ' << text_at(alarm, "field") << (values.empty() ? "" : " ") << values << '\n';
    }

    Streams& streams_;
    std::map<std::string, Json> before_;
};

struct Alarms {
    GatewayOptions gateway;
    std::vector<std::string> devices;
    bool follow = false, json = false;

    int run(Streams& streams) const {
        if (follow) return follow_all(streams);
        const std::vector<Json> alarms = wanted(parse_answer(gateway.ask("GET", "/alarms")));
        Table table{{"DEVICE", "LEVEL", "FIELD", " VALUE", "LIMIT", " FOR", " HEARD"}};
        for (const Json& alarm : alarms) {
            if (json) streams.out << ano::json_text(alarm) << '\n';
            else table.row(cells(alarm));
        }
        if (json) return fine;
        if (table.empty()) streams.out << "no value exceeds its limits\n";
        else table.write(streams.out, {}, streams.terminal ? streams.width : 0);
        return fine;
    }

private:
    static Table::Line cells(const Json& alarm) {
        return {device_text(alarm),
                text_at(alarm, "level"),
                text_at(alarm, "field"),
                judged_text(alarm),
                limit_text(alarm),
                time_text(number_at(alarm, "beyond_s")),
                time_text(number_at(alarm, "age_s"))};
    }

    bool is_wanted(const Json& alarm) const {
        const auto is_it = [&](const std::string& word) {
            const auto called = ano::address_called(word);
            const auto of = ano::address_called(text_at(alarm, "device"));
            if (std::holds_alternative<ano::JsonFault>(called)) return word == text_at(alarm, "name");
            return std::holds_alternative<std::uint8_t>(of) && std::get<std::uint8_t>(called) == std::get<std::uint8_t>(of);
        };
        return devices.empty() || std::any_of(devices.begin(), devices.end(), is_it);
    }
    std::vector<Json> wanted(const Json& answer) const {
        std::vector<Json> all;
        for (const Json& alarm : at(answer, "alarms"))
            if (is_wanted(alarm)) all.push_back(alarm);
        return all;
    }

    int follow_all(Streams& streams) const {
        asio::io_context io{1};
        asio::signal_set signals{io, SIGINT, SIGTERM};
        signals.async_wait([&io](anogate::error_code, int) { io.stop(); });
        ChangePrinter printer{streams};
        bool was_empty = false;
        http::Request request;
        request.method = "GET";
        request.target = "/alarms";
        request.headers.push_back({"Accept", "application/x-ndjson"});
        std::optional<http::Outcome> outcome;
        http::Client client{io, gateway.socket()};
        const auto accept = [&](std::string_view line) {
            const std::vector<Json> alarms = wanted(parse_answer(std::string{line}));
            if (!json) return printer.print(alarms);
            if (std::exchange(was_empty, alarms.empty()) && alarms.empty()) return;    // repeats without alarms are omitted
            streams.out << ano::json_text(Json{{"alarms", alarms}}) << '\n';
            streams.out.flush();
            if (!streams.out) io.stop();
        };
        client.stream(std::move(request), accept, [&](http::Outcome ended) {
            outcome = std::move(ended);
            io.stop();
        });
        io.run();
        if (!outcome) return fine;
        if (outcome->answer.status / 100 != 2)
            throw Failure{outcome->answer.status == 0 ? outcome->fault : format_failure(outcome->answer)};
        throw Failure{outcome->fault.empty() ? "the gateway stopped" : outcome->fault};
    }
};

}    // namespace

Run add_alarms(Options& options) {
    const auto self = std::make_shared<Alarms>();
    options.push_back(
        {"--follow", &self->follow, "", "Keep running; print a line when an alarm starts, changes its level or ends"});
    options.push_back({"--device", &self->devices, "DEVICE...", "Show only these devices, by address or name"});
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--json", &self->json, "",
                       "Print one JSON object per alarm and line; with --follow, one object with all alarms at each change"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
