// The file descriptor store of systemd (sd_notify(3), FDSTORE=1; sd_listen_fds(3)): what a service leaves there, the next start of it
// has. FileDescriptorStoreMax= of the unit says how much.
#pragma once
#include <link/unique_fd.hpp>

#include <string>
#include <utility>
#include <vector>

namespace anogate {

using NamedDescriptor = std::pair<std::string, UniqueFd>;

/// What is there for this process, and is taken out. The environment knows nothing of it afterwards. To be called once, before
/// another thread runs.
std::vector<NamedDescriptor> take_descriptors();

/// Puts copies there, in place of what had these names, and returns when systemd has them, or does not take them in time. False: it has
/// not; without systemd nothing happens.
bool store_descriptors(const std::vector<NamedDescriptor>& descriptors);

}    // namespace anogate
