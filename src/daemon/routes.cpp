#include <daemon/control_link.hpp>
#include <daemon/frame_watch.hpp>
#include <daemon/gateway.hpp>
#include <daemon/gpio_control.hpp>
#include <daemon/routes.hpp>
#include <daemon/send_frame.hpp>
#include <daemon/status.hpp>
#include <daemon/watch_session.hpp>
#include <http/routes.hpp>

#include <memory>

namespace anogate {
namespace {

http::Response json(std::string body) {
    http::Response response;
    response.body = std::move(body);
    return response;
}

// What was asked before the loop stood still is not carried out behind that.
template <class Function>
http::Routes::Function in_time(Gateway& gateway, Function function) {
    return [&gateway, function](const http::Request& request) {
        gateway.turn();
        return gateway.loop().may_have_waited(request.came_at)
                   ? http::try_again("the gateway stood still meanwhile: what waited is not carried out late, ask again")
                   : function(request);
    };
}

// What the routes of streams have in common, as long as they.
struct Streams {
    explicit Streams(Gateway& gateway) : watch{gateway}, frames{gateway, watch} {}
    FrameWatch watch;
    FrameStreams frames;
};

http::Response join_link(Gateway& gateway, const http::Request& request) {
    if (http::Response fault = http::web_socket_fault(request); fault.status != 200) return fault;
    ControlLink* const link = gateway.control();
    return link ? link->join(request, gateway.settings().gateway.id)
                : http::error(503, "all 64 links are in use: there is no place for the link 'control'");
}

}    // namespace

void add_routes(http::Routes& routes, Gateway& gateway) {
    using http::Request;
    routes.add("GET", "/status", [&gateway](const Request&) { return json(status_json(gateway)); });
    routes.add("POST", "/gpio", in_time(gateway, [&gateway](const Request& request) {
                   return gpio_request(gateway.gpio(), request.body, gateway.now());
               }));
    routes.add("POST", "/send", in_time(gateway, [&gateway](const Request& request) { return send_request(gateway, request); }));
    routes.add("GET", "/frames", [streams = std::make_shared<Streams>(gateway)](const Request& request) {
        return streams->frames.answer(request);
    });
    routes.add("GET", "/link", [&gateway](const Request& request) { return join_link(gateway, request); });
}

}    // namespace anogate
