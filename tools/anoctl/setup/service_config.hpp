// The first configuration of the service, written by `anoctl setup`.
#pragma once
#include <cstdint>
#include <string>

namespace anoctl {

/// JSON with comments: a serial link to `device`, a port for ground stations, and the page on this computer. `baud` 0: the default of the link.
std::string service_config(const std::string& device, std::uint32_t baud, std::uint8_t v7_device = 0);

}    // namespace anoctl
