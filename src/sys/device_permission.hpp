// The missing permission to open a serial port, and how to get it.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace anogate {

/// A system user: its id is below the first id of ordinary users (UID_MIN in login.defs).
constexpr bool is_service_user(uid_t user) noexcept { return user < 1000; }

/// The user that opens a device.
struct DeviceUser {
    uid_t uid = 0;
    std::string name;
    std::vector<gid_t> groups;    // of the process: groups added after the login are missing

    static DeviceUser this_process();
};

/// The permission that `user` lacks to read and write `device`, and how to get it; empty: none, or none that can be found.
/// `device`: a path below `root` that is not a symbolic link.
std::string missing_permission(const std::filesystem::path& root, const std::string& device, const DeviceUser& user);

}    // namespace anogate
