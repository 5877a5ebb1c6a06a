// The names in a hosts file, hosts(5).
#pragma once
#include <gateway/host_spec.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// ASCII letters alone, as in the names of hosts.
std::string in_lower_case(std::string_view name);

/// With names in lower case. Lines without a valid address are ignored.
HostAddresses names_in_hosts(std::string_view text);

/// The names in the file `path`; none if it is unreadable.
HostAddresses read_hosts_file(const std::string& path);

}    // namespace anogate
