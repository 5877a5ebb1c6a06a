// POST /reload and POST /reload/confirm.
#pragma once

namespace anogate {

class Reload;
namespace http {
class Routes;
}

/// `reload` must outlive the routes.
void add_reload_routes(http::Routes& routes, Reload& reload);

}    // namespace anogate
