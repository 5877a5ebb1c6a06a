// What the gateway answers on its control interface.
#pragma once
#include <daemon/network_door.hpp>
#include <daemon/page.hpp>

#include <functional>

namespace anogate {

class Gateway;
namespace http {
class Routes;
}

/// Every row says what it answers: `GET /` and the reference are made of that. The gateway outlives the routes. `door` tells
/// where HTTP is served, when it is asked. `page` is what browsers get.
void add_routes(
    http::Routes& routes, Gateway& gateway, std::function<NetworkDoor()> door = [] { return NetworkDoor{}; }, Page page = {});

}    // namespace anogate
