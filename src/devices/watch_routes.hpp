// The requests that watch devices: their log, their alarm limits, what is in alarm.
#pragma once

namespace anogate {

class DeviceService;
namespace http {
class Routes;
}

/// `service` must outlive the routes and their answers.
void add_watch_routes(http::Routes& routes, DeviceService& service);

}    // namespace anogate
