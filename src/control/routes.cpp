#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano_json/answer_json.hpp>
#include <ano_json/frame_json.hpp>
#include <control/raw_streams.hpp>
#include <control/routes.hpp>
#include <control/send_frame.hpp>
#include <control/watch_session.hpp>
#include <devices/device_routes.hpp>
#include <devices/device_service.hpp>
#include <devices/watch_routes.hpp>
#include <foxglove/foxglove_streams.hpp>
#include <gpio/gpio_control.hpp>
#include <http/routes.hpp>
#include <http/served_file.hpp>
#include <runtime/control_link.hpp>
#include <runtime/gateway.hpp>
#include <status/metrics.hpp>
#include <status/status.hpp>
#include <sys/error_fault.hpp>

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <memory>
#include <utility>
#include <variant>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using http::Access;
using http::Request;

http::Response json(std::string body) {
    http::Response response;
    response.body = std::move(body);
    return response;
}

http::Response list_of(const http::Routes& routes) {
    Json list{{"name", "anogate"}, {"version", ANOGATE_VERSION}, {"routes", Json::array()}};
    for (const http::Routes::Row& row : routes.rows())
        list["routes"].push_back(
            {{"method", row.method}, {"path", row.pattern}, {"access", text(row.access)}, {"answers", row.answers}});
    return json(line_of(std::move(list)));
}

// A browser gets the page without a token, because the page prompts for it; the list of routes needs a token. Foxglove clients
// use only this path.
http::Response front(const http::Routes& routes, const Page& page, FoxgloveStreams& foxglove, const Request& request) {
    if (is_foxglove(request) && !request.is_foreign)
        return request.access == Access::open ? http::needs_token("Foxglove needs a token: ws://HOST:PORT/?token=TOKEN")
                                              : foxglove.answer(request);
    if (page.is_wanted_by(request)) return page.file({}, request);
    return request.access == Access::open ? http::needs_token("this path needs a token") : list_of(routes);
}

void add_page(http::Routes& routes, Page page, FoxgloveStreams& foxglove) {
    const auto kept = std::make_shared<const Page>(std::move(page));
    routes.add({"GET", "/", Access::open,
                "the page, for clients that accept text/html; otherwise this list, for clients that may view",
                [&routes, kept, &foxglove](const Request& request) { return front(routes, *kept, foxglove, request); }});
    routes.add({"GET", "/web/{file}", Access::open, "a file of the page",
                [kept](const Request& request) { return kept->file(request.parameter("file"), request); }});
}

// Opens the file for each request, because it may be replaced at any time. It may be a symbolic link.
std::variant<UniqueFd, http::Response> open_map(const std::string& path) {
    const std::string where = "control.map: " + path;
    UniqueFd file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)};
    struct stat is {};
    if (!file || ::fstat(file.get(), &is) != 0) return http::error(404, error_fault(where, errno));
    if (!S_ISREG(is.st_mode)) return http::error({"no_regular_file", where});
    return file;
}

http::Response map_answer(TaskPool& disk, const MapSettings& map, const Request& request) {
    if (map.file.empty()) return http::error({"no_map"});
    return served(disk, request, {.open = [path = map.file] { return open_map(path); }, .type = "application/vnd.pmtiles"});
}

http::Response metrics_answer(const Request& request, Gateway& gateway, const ListenerInfo& listener, DeviceService& devices) {
    const MetricsForm form = metrics_form(request.header("Accept"));
    http::Response response;
    response.type = content_type(form);
    MetricsSnapshot snapshot = metrics_snapshot(gateway, gateway.now());
    snapshot.wrong_tokens = listener.wrong_tokens;
    snapshot.evicted = listener.evicted;
    snapshot.certificate_days = listener.validity.days_left;
    snapshot.guessing_clients = listener.guessing_clients;
    for (const ActiveAlarm& alarm : devices.alarms().watch().active(gateway.now()))
        ++(alarm.level == AlarmLevel::red ? snapshot.red_alarms : snapshot.amber_alarms);
    response.body = metrics(std::move(snapshot), form);
    return response;
}

http::Response forget_route(const std::string& word, Gateway& gateway, DeviceService& devices) {
    const auto called = ano::address_called(word);
    if (const auto* fault = std::get_if<ano::JsonFault>(&called)) return http::error(400, fault->what);
    const auto address = std::get<std::uint8_t>(called);
    const bool was_known = gateway.forwarder().forget(address), was_watched = devices.forget_values(address);
    if (!was_known && !was_watched) return http::error(404, ano::hex_byte(address) + " was not seen: there is nothing to forget");
    return json(line_of({{"address", ano::hex_byte(address)}, {"forgotten", true}}));
}

// Refuses a request that waited during a standstill of the loop.
template <class Function>
http::Routes::Function in_time(Gateway& gateway, Function function) {
    return [&gateway, function](const http::Request& request) {
        gateway.turn();
        return gateway.loop().may_have_waited(request.came_at) ? http::try_again(ano::Fault{"request_expired"})
                                                               : function(request);
    };
}

http::Response join_link(Gateway& gateway, const http::Request& request) {
    if (http::Response fault = http::web_socket_fault(request); fault.status != 200) return fault;
    ControlLink* const link = gateway.control();
    return link ? link->join(request, gateway.settings().gateway.id) : http::error(503, no_control_link);
}

}    // namespace

void add_routes(http::Routes& routes, const ServedParts& parts, const std::function<ListenerInfo()>& listener, Page page) {
    Gateway& gateway = parts.gateway;
    add_page(routes, std::move(page), parts.foxglove);
    routes.add(
        {"GET", "/status", Access::view,
         "the state of the gateway, its links, routes, conflicts, tunnel and GPIO lines, where it serves HTTP, and lost devices",
         [&gateway, parts, listener](const Request&) {
             const auto lost = lost_json(parts.devices);
             return json(status_json(gateway, listener(), &lost));
         }});
    routes.add({"GET", "/links", Access::view, "only the links of the status",
                [&gateway](const Request&) { return json(links_json(gateway)); }});
    routes.add({"GET", "/routes", Access::view, "where frames to each address go: only the routes of the status",
                [&gateway](const Request&) { return json(routes_json(gateway)); }});
    routes.add_without_body({"DELETE", "/routes/{address}", Access::control, "forgets where the address was seen",
                             [&gateway, parts](const Request& request) {
                                 return forget_route(std::string{request.parameter("address")}, gateway, parts.devices);
                             }});
    routes.add({"GET", "/messages", Access::view, "the messages of the protocol, with the flexible ones of the configuration",
                [&gateway](const Request&) { return json(messages_json(gateway)); }});
    routes.add(
        {"GET", "/map.pmtiles", Access::view, "the map of the page (control.map), with ranges",
         [&gateway, parts](const Request& request) { return map_answer(parts.disk, gateway.settings().control.map, request); }});
    routes.add({"GET", "/metrics", Access::view, "the counters for Prometheus, as text or as OpenMetrics",
                [&gateway, parts, listener](const Request& request) {
                    return metrics_answer(request, gateway, listener(), parts.devices);
                }});
    routes.add({"POST", "/gpio", Access::control, "pulses a reset line, or switches power off and on again",
                in_time(gateway, [&gateway](const Request& request) {
                    return gpio_request(gateway.gpio(), request.body, gateway.now());
                })});
    routes.add({"POST", "/send", Access::control,
                "sends one frame, as hex digits or as JSON, and returns the links that it was sent to",
                in_time(gateway, [&gateway](const Request& request) { return send_request(gateway, request); })});
    routes.add({"GET", "/frames", Access::view, "the forwarded frames, as lines of JSON or as a WebSocket",
                [parts](const Request& request) { return parts.frames.answer(request); }});
    routes.add(
        {"GET", "/foxglove", Access::view,
         "as a WebSocket: the protocol of Foxglove, which shows the frames (encoding=cdr or json); also at / for clients that "
         "offer its subprotocol",
         [parts](const Request& request) { return parts.foxglove.answer(request); }, 0, true});
    routes.add({"GET", "/link", Access::control, "as a WebSocket: the client becomes a channel of the gateway",
                [&gateway](const Request& request) { return join_link(gateway, request); }, 0, true});
    routes.add({"GET", "/links/{link}/raw", Access::view,
                "as a WebSocket: the raw bytes of a serial, hid, pty, udp, tcp or sim link, in both directions; with a control "
                "token the client can send, and with ?exclusive it has exclusive use of the link",
                [parts](const Request& request) { return parts.raw.answer(request); }, 0, true});
    add_device_routes(routes, parts.devices);
}

}    // namespace anogate
