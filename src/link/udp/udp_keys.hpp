// Configuration shared by both kinds of UDP links.
#pragma once
#include <config/key_rows.hpp>
#include <config/link_kind.hpp>

namespace anogate {

inline constexpr std::string_view one_interface_help = "use only this network interface, such as wg0 (default: any)";

/// An error if `endpoint` names an interface other than `interface`.
void check_interface(const std::string& interface, const EndpointSpec& endpoint, LinkFaults& faults);

}    // namespace anogate
