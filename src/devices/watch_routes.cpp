#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano/time.hpp>
#include <ano_json/json_line.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/text.hpp>
#include <devices/device_json.hpp>
#include <devices/device_service.hpp>
#include <devices/job_answers.hpp>
#include <devices/line_stream.hpp>
#include <devices/watch_routes.hpp>
#include <http/routes.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using http::Access;
using http::Request;
using http::Response;

Response watch_response(const Json& json) {
    Response response;
    response.body = ano::json_line(json);
    return response;
}

/// A message of a stream: the same without its line end.
std::string watch_line(const Json& json) {
    std::string line = ano::json_line(json);
    line.pop_back();
    return line;
}

std::variant<std::uint8_t, Response> address_in(DeviceService& service, const Request& request) {
    const auto address = service.address_of(request.parameter("device"), service.net().now());
    if (const auto* unknown = std::get_if<NotBegun>(&address)) return answer_of(*unknown);
    return std::get<std::uint8_t>(address);
}

Json log_line_json(const DeviceLog::Line& line, std::uint8_t device, const DeviceTexts& texts) {
    Json json{{"n", line.number}, {"time", line.seconds()}, {"device", ano::hex_byte(device)}, {"link", line.link}};
    if (line.value) json["value"] = value_json(static_cast<double>(*line.value), ano::Type::f32, texts);
    else json["color"] = line.color;
    if (line.is_red() && line.origin == DeviceLog::Origin::anybody) json["counts"] = false;
    json["text"] = texts.display_text(line.text);
    return json;
}

struct FoundLine {
    const DeviceLog::Line* line = nullptr;
    std::uint8_t device = 0;
};

// Lines of all devices: per origin at most the number that is stored for one device.
std::vector<FoundLine> last_lines(const DeviceLog& log, double since) {
    std::vector<FoundLine> found;
    for (unsigned a = 0; a < ano::address::broadcast; ++a)
        for (const DeviceLog::Line& line : log.lines(static_cast<std::uint8_t>(a)))
            if (line.seconds() >= since) found.push_back({&line, static_cast<std::uint8_t>(a)});
    std::sort(found.begin(), found.end(), [](const FoundLine& a, const FoundLine& b) { return a.line->number < b.line->number; });
    for (const auto origin : {DeviceLog::Origin::known, DeviceLog::Origin::anybody}) {
        const auto is_of_it = [origin](const FoundLine& one) { return one.line->origin == origin; };
        auto of_it = static_cast<std::size_t>(std::count_if(found.begin(), found.end(), is_of_it));
        std::erase_if(found, [&](const FoundLine& one) { return is_of_it(one) && of_it > DeviceLog::max_lines && of_it-- > 0; });
    }
    return found;
}

/// Lines that one client follows: first the stored ones, then each new one. Lines that were displaced before they were sent to
/// the client are counted.
class LogLines {
public:
    LogLines(DeviceService& service, std::uint8_t device, double since)
        : service_{service},
          device_{device},
          since_{since},
          kept_{of_all() ? service.log().last() : service.log().count(device)} {
        after_ = kept_;
        if (of_all()) {
            if (const auto last = last_lines(service.log(), since); !last.empty()) after_ = place_of(*last.front().line) - 1;
        } else if (const auto& lines = service.log().lines(device); !lines.empty()) {
            after_ = place_of(lines.front()) - 1;
        }
    }

    std::string operator()() {
        while (const auto next = next_line()) {
            const std::uint64_t place = place_of(*next->line), expected = std::max(after_, kept_) + 1;
            after_ = place - 1;
            if (place > expected) return watch_line({{"lost", place - expected}});
            after_ = place;
            if (place > kept_ || next->line->seconds() >= since_)
                return watch_line(log_line_json(*next->line, next->device, service_.texts(next->device)));
        }
        return {};
    }

private:
    bool of_all() const noexcept { return device_ == ano::address::broadcast; }
    /// Among the lines that the client follows, without gaps.
    std::uint64_t place_of(const DeviceLog::Line& line) const noexcept { return of_all() ? line.number : line.of_device; }
    std::optional<FoundLine> next_line() const {
        std::optional<FoundLine> first;
        const unsigned from = of_all() ? 0u : device_, to = of_all() ? ano::address::broadcast : device_ + 1u;
        for (unsigned a = from; a < to; ++a) {
            const auto& lines = service_.log().lines(static_cast<std::uint8_t>(a));
            const auto next = std::partition_point(lines.begin(), lines.end(),
                                                   [this](const DeviceLog::Line& line) { return place_of(line) <= after_; });
            if (next != lines.end() && (!first || next->number < first->line->number))
                first = FoundLine{&*next, static_cast<std::uint8_t>(a)};
        }
        return first;
    }

    DeviceService& service_;
    std::uint8_t device_;
    double since_;
    std::uint64_t kept_;         // the place of the last stored line when the client joined
    std::uint64_t after_ = 0;    // the place of the last line that was sent
};

Response log_answer(DeviceService& service, const Request& request) {
    auto address = address_in(service, request);
    if (auto* unknown = std::get_if<Response>(&address)) return std::move(*unknown);
    const auto device = std::get<std::uint8_t>(address);
    double since = 0;
    if (const auto word = request.query_value("since")) {
        const auto [end, ec] = std::from_chars(word->data(), word->data() + word->size(), since);
        if (ec != std::errc{} || end != word->data() + word->size() || !std::isfinite(since))    // it accepts "nan"
            return http::error(400, "'since' must be seconds since 1970, not " + ano::in_quotes(*word));
    }
    if (requests_lines(request)) return line_stream(service.log_clients(), LogLines{service, device, since}, request);
    const DeviceLog& log = service.log();
    Json lines = Json::array();
    if (device == ano::address::broadcast) {
        for (const FoundLine& one : last_lines(log, since))
            lines.push_back(log_line_json(*one.line, one.device, service.texts(one.device)));
        return watch_response({{"device", ano::hex_byte(device)}, {"lines", std::move(lines)}});
    }
    const auto& kept = log.lines(device);
    for (const DeviceLog::Line& line : kept)
        if (line.seconds() >= since) lines.push_back(log_line_json(line, device, service.texts(device)));
    return watch_response({{"device", ano::hex_byte(device)},
                           {"count", log.count(device)},
                           {"red", log.red(device)},
                           {"forgotten", log.count(device) - kept.size()},
                           {"lines", std::move(lines)}});
}

Json limits_json(DeviceService& service, std::uint8_t device) {
    Json json = AlarmLimits::json(service.limits().of(device));
    json["device"] = ano::hex_byte(device);
    json["version"] = service.limits().version(device);
    return json;
}

Response get_limits(DeviceService& service, const Request& request) {
    auto address = address_in(service, request);
    if (auto* unknown = std::get_if<Response>(&address)) return std::move(*unknown);
    return watch_response(limits_json(service, std::get<std::uint8_t>(address)));
}

Response put_limits(DeviceService& service, const Request& request) {
    if (service.net().may_have_waited(request.came_at)) return http::try_again(ano::Fault{"request_expired"});
    auto address = address_in(service, request);
    if (auto* unknown = std::get_if<Response>(&address)) return std::move(*unknown);
    const auto device = std::get<std::uint8_t>(address);
    if (device == 0 || device == ano::address::broadcast) return http::error(400, "limits belong to one device");
    const auto body = ano::json_body(request.body);
    if (const auto* wrong = std::get_if<std::string>(&body)) return http::error(400, *wrong);
    auto list = AlarmLimits::parse(std::get<Json>(body));
    if (const auto* wrong = std::get_if<std::string>(&list)) return http::error(422, *wrong);
    const std::string unknown = AlarmLimits::unknown_field(std::get<AlarmLimits::List>(list), device, service.net().layouts());
    if (!unknown.empty()) return http::error(422, unknown);
    return http::later([&service, device, list = std::get<AlarmLimits::List>(std::move(list))](const auto& respond) {
        service.keep_limits(device, list, [&service, device, respond](const std::string& fault) {
            Json json = limits_json(service, device);
            json["kept"] = fault.empty();
            if (!fault.empty()) json["why"] = fault;
            respond(watch_response(json));
        });
    });
}

/// The unit of a field in the message table; empty: it has none, or the message is a flexible one.
std::string_view field_unit(const AlarmLimit& limit) {
    const std::string_view field = limit.field, message = field.substr(0, field.find('.'));
    for (const ano::Message& row : ano::messages) {
        if (row.name != message) continue;
        if (const ano::Field* const one = row.field(field.substr(message.size() + 1))) return one->unit;
    }
    return {};
}

Json alarm_json(DeviceService& service, const ActiveAlarm& alarm, ano::TimePoint now) {
    const auto seconds_since = [now](ano::TimePoint at) {
        return static_cast<double>(std::chrono::duration_cast<std::chrono::milliseconds>(now - at).count()) / 1000;
    };
    const AlarmLimit& limit = alarm.limit;
    Json json{{"device", ano::hex_byte(alarm.device)}};
    if (const auto info = service.info(alarm.device)) json["name"] = service.texts(alarm.device).display_text(info->name);
    json["field"] = limit.field;
    json["side"] = limit.is_below ? "below" : "above";
    json["level"] = text(alarm.level);
    json["value"] = alarm.value;
    json["limit"] = alarm.level == AlarmLevel::red ? *limit.red : *limit.amber;
    if (const auto unit = field_unit(limit); !unit.empty()) json["unit"] = unit;
    if (limit.cells) json["cells"] = *limit.cells;
    json["beyond_s"] = seconds_since(alarm.since);
    json["age_s"] = seconds_since(alarm.heard_at);
    return json;
}

Json alarms_json(DeviceService& service, const std::vector<ActiveAlarm>& alarms, const std::vector<WatchedDevice>& devices) {
    const ano::TimePoint now = service.net().now();
    Json list = Json::array();
    for (const ActiveAlarm& alarm : alarms) list.push_back(alarm_json(service, alarm, now));
    Json json{{"alarms", std::move(list)}};
    for (const WatchedDevice& device : devices) {
        Json& one = json["devices"].emplace_back(Json{{"address", ano::hex_byte(device.address)}, {"lost", device.is_lost}});
        if (device.is_lost) append_loss(one, service, device, now);
    }
    return json;
}

/// All alarms and lost devices, completely, at each change: a state that was not sent in time is replaced.
class AlarmLines {
public:
    explicit AlarmLines(DeviceService& service) : service_{service} {}
    std::string operator()() {
        AlarmFeed& feed = service_.alarms();
        if (!sent_version_) service_.look_for_alarms(service_.net().now());
        if (sent_version_ == feed.version()) return {};
        sent_version_ = feed.version();
        return watch_line(alarms_json(service_, feed.sent_alarms(), feed.sent_devices()));
    }

private:
    DeviceService& service_;
    std::optional<std::uint64_t> sent_version_;    // the version sent; std::nullopt: nothing yet
};

Response alarms_answer(DeviceService& service, const Request& request) {
    if (requests_lines(request)) return line_stream(service.alarms().clients(), AlarmLines{service}, request);
    return watch_response(alarms_json(service, service.alarms().watch().active(service.net().now()), {}));
}

}    // namespace

void append_loss(Json& json, DeviceService& service, const WatchedDevice& device, ano::TimePoint now) {
    if (const auto info = service.info(device.address)) json["name"] = service.texts(device.address).display_text(info->name);
    json["age"] = std::round(std::chrono::duration<double>(now - device.heard_at).count() * 10) / 10;
    if (device.flag) json["sflag"] = *device.flag;
    if (!device.elsewhere.empty()) json["elsewhere"] = device.elsewhere;
}

Json lost_json(DeviceService& service) {
    const ano::TimePoint now = service.net().now();
    Json all = Json::array();
    for (const WatchedDevice& device : service.lost(now)) {
        Json& one = all.emplace_back(Json{{"address", ano::hex_byte(device.address)}});
        append_loss(one, service, device, now);
    }
    return all;
}

void add_watch_routes(http::Routes& routes, DeviceService& service) {
    routes.add({"GET", "/alarms", Access::view,
                "the device values that exceed their limits for long enough; with Accept: application/x-ndjson a line, "
                "as a WebSocket a message, for each change and once a second while there are some; also lost devices",
                [&service](const Request& request) { return alarms_answer(service, request); }});
    routes.add({"GET", "/devices/{device}/log", Access::view,
                "the last 500 log lines of the device, or with 0xFF of all devices (since=T: only those since T, in seconds "
                "since 1970); with Accept: application/x-ndjson or as a WebSocket, these and all new ones",
                [&service](const Request& request) { return log_answer(service, request); }});
    routes.add({"GET", "/devices/{device}/limits", Access::view, "the alarm limits of the device's values",
                [&service](const Request& request) { return get_limits(service, request); }});
    routes.add({"PUT", "/devices/{device}/limits", Access::control,
                "replaces the alarm limits of the device's values, {\"limits\": [...]}; stored across restarts, for all viewers",
                [&service](const Request& request) { return put_limits(service, request); }});
}

}    // namespace anogate
