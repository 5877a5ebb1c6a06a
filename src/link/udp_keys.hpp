// What the two kinds of UDP links share in the configuration.
#pragma once
#include <config/key_rows.hpp>
#include <config/link_kind.hpp>

namespace anogate {

inline constexpr std::string_view one_interface_help =
    "hear and send by this network interface alone, such as wg0 (default: any)";

/// An endpoint with an interface of its own must not have another one.
void check_interface(const std::string& interface, const EndpointSpec& endpoint, LinkFaults& faults);

}    // namespace anogate
