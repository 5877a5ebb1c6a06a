// Reads and writes the waypoints of a device.
#pragma once
#include <devices/waypoint_forms.hpp>
#include <devices/works/work.hpp>

#include <memory>
#include <vector>

namespace anogate {

std::unique_ptr<Work> read_waypoints(const WorkPlace& place, WaypointForm form);
std::unique_ptr<Work> write_waypoints(const WorkPlace& place, std::vector<ano::host::Waypoint> waypoints);

}    // namespace anogate
