// Which permission is missing to open a serial port, and how to get it.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace anogate {

/// No person's: below the first user id that those have (login.defs, UID_MIN).
constexpr bool is_service_user(uid_t user) noexcept { return user < 1000; }

/// Who wants to open a device.
struct DeviceUser {
    uid_t uid = 0;
    std::string name;
    std::vector<gid_t> groups;    // of the process: a group that was given since the login is not among them

    static DeviceUser this_process();
};

/// Which permission `user` lacks to read and write `device`, a path that is no link below `root`, and how to get it; empty: none, or
/// none that can be seen.
std::string missing_permission(const std::filesystem::path& root, const std::string& device, const DeviceUser& user);

}    // namespace anogate
