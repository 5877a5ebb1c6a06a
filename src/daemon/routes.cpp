#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano_json/frame_json.hpp>
#include <daemon/answer_json.hpp>
#include <daemon/gateway.hpp>
#include <daemon/gpio_control.hpp>
#include <daemon/metrics.hpp>
#include <daemon/routes.hpp>
#include <daemon/status.hpp>
#include <http/routes.hpp>

#include <nlohmann/json.hpp>

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

http::Response metrics_answer(const Request& request, Gateway& gateway) {
    const MetricsForm form = metrics_form(request.header("Accept"));
    http::Response response;
    response.type = content_type(form);
    response.body = metrics(metrics_snapshot(gateway, gateway.now()), form);
    return response;
}

http::Response forget_route(const std::string& word, Gateway& gateway) {
    const auto called = ano::address_called(word);
    if (const auto* fault = std::get_if<ano::JsonFault>(&called)) return http::error(400, fault->what);
    const auto address = std::get<std::uint8_t>(called);
    if (!gateway.forget(address)) return http::error(404, ano::hex_byte(address) + " was not heard: there is nothing to forget");
    return json(line_of({{"address", ano::hex_byte(address)}, {"forgotten", true}}));
}

}    // namespace

void add_routes(http::Routes& routes, Gateway& gateway) {
    routes.add({"GET", "/", Access::view, "this list", [&routes](const Request&) { return list_of(routes); }});
    routes.add({"GET", "/status", Access::view, "the state of the gateway, its links, routes, conflicts, tunnel and GPIO lines",
                [&gateway](const Request&) { return json(status_json(gateway)); }});
    routes.add({"GET", "/links", Access::view, "the links of the status alone",
                [&gateway](const Request&) { return json(links_json(gateway)); }});
    routes.add({"GET", "/routes", Access::view, "where each address leads: the routes of the status alone",
                [&gateway](const Request&) { return json(routes_json(gateway)); }});
    routes.add({"DELETE", "/routes/{address}", Access::control, "forgets where the address was heard",
                [&gateway](const Request& request) { return forget_route(std::string{request.parameter("address")}, gateway); }});
    routes.add({"GET", "/messages", Access::view, "the messages of the protocol, with the flexible ones of the configuration",
                [&gateway](const Request&) { return json(messages_json(gateway)); }});
    routes.add({"GET", "/metrics", Access::view, "the counters for Prometheus, as text or as OpenMetrics",
                [&gateway](const Request& request) { return metrics_answer(request, gateway); }});
    routes.add({"POST", "/gpio", Access::control, "pulses a reset line, or switches power off and on again",
                [&gateway](const Request& request) { return gpio_request(gateway.gpio(), request.body, gateway.now()); }});
}

}    // namespace anogate
