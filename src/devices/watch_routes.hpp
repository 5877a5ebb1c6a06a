// The requests that watch devices: their log, their alarm limits, their alarms.
#pragma once
#include <ano/time.hpp>
#include <devices/loss_watch.hpp>

#include <nlohmann/json_fwd.hpp>

namespace anogate {

class DeviceService;
namespace http {
class Routes;
}

/// `service` must outlive the routes and their answers.
void add_watch_routes(http::Routes& routes, DeviceService& service);

/// Adds the lost device, the time since its last frame, and its last state.
void append_loss(nlohmann::ordered_json& json, DeviceService& service, const WatchedDevice& device, ano::TimePoint now);
/// The devices that are lost, one object each.
nlohmann::ordered_json lost_json(DeviceService& service);

}    // namespace anogate
