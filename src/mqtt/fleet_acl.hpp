// Access rules for mosquitto: one file for a whole fleet.
#pragma once
#include <string>

namespace anogate {

std::string fleet_acl();

}    // namespace anogate
