// What the gateway answers on its control interface.
#pragma once

namespace anogate {

class Gateway;
namespace http {
class Routes;
}

/// Every row says what it answers: `GET /` and the reference are made of that. The gateway outlives the routes.
void add_routes(http::Routes& routes, Gateway& gateway);

}    // namespace anogate
