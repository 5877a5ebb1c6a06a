// The first configuration of the service, as `anoctl setup` writes it.
#pragma once
#include <cstdint>
#include <string>

namespace anoctl {

/// JSON with comments: a serial link to `device`, a port for ground stations, and the page on this computer. `baud` 0: its default.
std::string service_config(const std::string& device, std::uint32_t baud);

}    // namespace anoctl
