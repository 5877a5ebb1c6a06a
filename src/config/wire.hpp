// Distinguishes two links with the same name in two gateways.
#pragma once
#include <config/link_kind.hpp>

#include <string>

namespace anogate {

/// "serial:/dev/ttyUSB0"
std::string wire_of(const LinkSettings& link);

}    // namespace anogate
