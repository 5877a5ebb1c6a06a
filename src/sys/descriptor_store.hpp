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

/// Returns the descriptors that were passed to this process, and removes their variables from the environment. To be called once,
/// before another thread runs. If LISTEN_PID is another process (our parent), its descriptors are not changed, as in
/// sd_listen_fds(3): they stay open and unused while we run. No other program can inherit them, because we start none.
std::vector<NamedDescriptor> receive_descriptors();

/// Stores copies of at most 253 descriptors under one name. False: systemd did not accept them in time, or there is no systemd.
bool store_descriptors(const std::string& name, std::span<const int> descriptors);

/// Waits until systemd has processed all messages sent to it. False: timed out.
bool await_systemd();

}    // namespace anogate
