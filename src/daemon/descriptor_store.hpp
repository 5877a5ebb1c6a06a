// The file descriptor store of systemd (sd_notify(3), FDSTORE=1; sd_listen_fds(3)): what a service leaves there, the next start of it
// has. FileDescriptorStoreMax= of the unit says how much.
#pragma once
#include <link/unique_fd.hpp>

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace anogate {

using NamedDescriptor = std::pair<std::string, UniqueFd>;

/// What is there for this process, and is taken out. The environment knows nothing of it afterwards. To be called once, before
/// another thread runs. What LISTEN_PID says is for another process, whose child we are, stays as it is, as sd_listen_fds(3) leaves
/// it: it is open as long as we run, nothing uses it, and no program that we start could inherit it, for we start none.
std::vector<NamedDescriptor> take_descriptors();

/// Puts copies there, all of one name; at most 253. False: systemd does not take them in time, or there is none.
bool store_descriptors(const std::string& name, std::span<const int> descriptors);

/// Returns when systemd has all that was sent to it, or does not take it in time: false.
bool await_systemd();

}    // namespace anogate
