#include <daemon/gateway.hpp>
#include <daemon/gpio_control.hpp>
#include <daemon/routes.hpp>
#include <daemon/status.hpp>
#include <http/routes.hpp>

namespace anogate {
namespace {

http::Response json(std::string body) {
    http::Response response;
    response.body = std::move(body);
    return response;
}

}    // namespace

void add_routes(http::Routes& routes, Gateway& gateway) {
    using http::Request;
    routes.add("GET", "/status", [&gateway](const Request&) { return json(status_json(gateway)); });
    routes.add("POST", "/gpio",
               [&gateway](const Request& request) { return gpio_request(gateway.gpio(), request.body, gateway.now()); });
}

}    // namespace anogate
