// What clients may ask of devices, by HTTP or in the same process.
#pragma once

namespace anogate {

class DeviceService;
namespace http {
class Routes;
}

/// /devices… and /jobs…; every row says what it answers. `service` outlives the routes, and what was answered by them.
///
/// What asks a device is a job. It is answered when the job has ended, or, where Accept is application/x-ndjson, by a line for each
/// change of the job; an upgrade or a calibration at once, by 202 and the job. With ?while_connected the job is cancelled when its client goes.
void add_device_routes(http::Routes& routes, DeviceService& service);

}    // namespace anogate
