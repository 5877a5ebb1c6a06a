// The routes of the control interface.
#pragma once
#include <control/page.hpp>
#include <status/network_door.hpp>

#include <functional>

namespace anogate {

class Gateway;
namespace http {
class Routes;
}

/// Each route has a description, which `GET /` and the reference show. The gateway must outlive the routes. `door` returns the
/// present state of the TCP access. `page`: the page for browsers.
void add_routes(
    http::Routes& routes, Gateway& gateway, const std::function<NetworkDoor()>& door = [] { return NetworkDoor{}; },
    Page page = {});

}    // namespace anogate
