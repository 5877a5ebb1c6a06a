// The file descriptor store of systemd (sd_notify(3), FDSTORE=1; sd_listen_fds(3)): descriptors that a service stores there are passed
// to its next start. FileDescriptorStoreMax= in the unit limits their number.
#pragma once
#include <sys/unique_fd.hpp>

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace anogate {

using NamedDescriptor = std::pair<std::string, UniqueFd>;

/// Takes out the descriptors that were passed to this process, and removes their variables from the environment. Call it once, before
/// another thread runs. When LISTEN_PID is another process (our parent), its descriptors are left as they are, like sd_listen_fds(3)
/// does: they stay open and unused while we run, and no program can inherit them, since we start none.
std::vector<NamedDescriptor> take_descriptors();

/// Stores copies of at most 253 descriptors under one name. False: systemd did not take them in time, or there is no systemd.
bool store_descriptors(const std::string& name, std::span<const int> descriptors);

/// Waits until systemd has processed everything that was sent to it. False: it did not in time.
bool await_systemd();

}    // namespace anogate
