// The routes of the control interface.
#pragma once
#include <control/page.hpp>
#include <status/listener_info.hpp>

#include <functional>

namespace anogate {

class Gateway;
namespace http {
class Routes;
}

/// Each route has a description, which `GET /` and the reference show. The gateway must outlive the routes. `listener` returns the
/// present state of the TCP access. `page`: the page for browsers.
void add_routes(
    http::Routes& routes, Gateway& gateway, const std::function<ListenerInfo()>& listener = [] { return ListenerInfo{}; },
    Page page = {});

}    // namespace anogate
