// The requests about devices, by HTTP or in the same process.
#pragma once

namespace anogate {

class DeviceService;
namespace http {
class Routes;
}

/// Adds /devices… and /jobs…; every row documents its answer. `service` must outlive the routes and their answers.
///
/// A request to a device becomes a job. It is answered when the job has ended; with Accept: application/x-ndjson by a line for
/// each change of the job; for an upgrade or a calibration at once with 202 and the job. With ?while_connected the job is
/// cancelled when its client disconnects.
void add_device_routes(http::Routes& routes, DeviceService& service);

}    // namespace anogate
