// What the gateway answers on its control interface.
#pragma once

namespace anogate {

class Gateway;
namespace http {
class Routes;
}

/// GET /status, POST /gpio. The gateway outlives the routes.
void add_routes(http::Routes& routes, Gateway& gateway);

}    // namespace anogate
