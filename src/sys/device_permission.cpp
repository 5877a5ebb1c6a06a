#include <sys/device_permission.hpp>

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <utility>

namespace anogate {
namespace {

namespace fs = std::filesystem;

struct DeviceGroup {
    std::string name;
    std::vector<std::string> members;
};

fs::path in_tree(const fs::path& root, const std::string& path) { return root / path.substr(1); }

/// A line of /etc/group: dialout:x:20:pi,anogate
DeviceGroup group_of(const fs::path& root, gid_t id) {
    std::ifstream file{in_tree(root, "/etc/group")};
    for (std::string line; std::getline(file, line);) {
        std::istringstream fields{line};
        std::string name, password, number, members;
        std::getline(std::getline(std::getline(std::getline(fields, name, ':'), password, ':'), number, ':'), members);
        if (number != std::to_string(id)) continue;
        DeviceGroup group{name, {}};
        std::istringstream list{members};
        for (std::string member; std::getline(list, member, ',');) group.members.push_back(member);
        return group;
    }
    return {std::to_string(id), {}};
}

template <class T>
bool is_among(const std::vector<T>& list, const T& value) {
    return std::find(list.begin(), list.end(), value) != list.end();
}

std::string how_to_join(const DeviceGroup& group, const DeviceUser& user) {
    const bool is_service = is_service_user(user.uid);
    const std::string then = is_service ? "restart the service" : "log in again";
    if (is_among(group.members, user.name))
        return is_service ? "its user " + user.name + " was added to the group " + group.name + " after the last start: " + then
                          : "you were added to its group " + group.name + " after your last login: " + then;
    const std::string name = is_service ? user.name : "$USER";
    return "it belongs to the group " + group.name + ": sudo usermod -aG " + group.name + " " + name + ", and " + then;
}

std::string name_of(uid_t id) {
    const passwd* const entry = ::getpwuid(id);
    return entry != nullptr ? entry->pw_name : "user " + std::to_string(id);
}

}    // namespace

DeviceUser DeviceUser::this_process() {
    DeviceUser user;
    user.uid = ::geteuid();
    if (const passwd* entry = ::getpwuid(user.uid)) user.name = entry->pw_name;
    user.groups.resize(static_cast<std::size_t>(std::max(::getgroups(0, nullptr), 0)));
    if (::getgroups(static_cast<int>(user.groups.size()), user.groups.data()) < 0) user.groups.clear();
    user.groups.push_back(::getegid());
    return user;
}

std::string missing_permission(const fs::path& root, const std::string& device, const DeviceUser& user) {
    constexpr unsigned both = S_IROTH | S_IWOTH;
    struct stat s {};
    if (user.uid == 0 || ::stat(in_tree(root, device).c_str(), &s) != 0) return {};
    const bool in_group = is_among(user.groups, s.st_gid);
    const unsigned bits = s.st_uid == user.uid ? s.st_mode >> 6 : in_group ? s.st_mode >> 3 : s.st_mode;
    if ((bits & both) == both) return {};
    const DeviceGroup group = group_of(root, s.st_gid);
    if (group.name == "tty" && device.starts_with("/dev/pts/")) return "it is a pseudo-terminal of another user's program";
    if (group.name == "tty") {
        const std::string port = fs::path{device}.filename().string();
        const std::string service = port.starts_with("ttyTHS") ? "nvgetty" : "serial-getty@" + port;    // nvgetty: on a Jetson
        return "a login console uses it: sudo systemctl disable --now " + service + ", and restart";
    }
    if (s.st_uid == user.uid) return "you own it, but its mode denies access: chmod u+rw " + device;
    if (s.st_uid != 0 && ((s.st_mode >> 3) & both) != both)
        return "it belongs to " + name_of(s.st_uid) + ", and its mode denies access to others: sudo chmod a+rw " + device;
    if (s.st_gid == 0 || ((s.st_mode >> 3) & both) != both)
        return "only root may open it: add a udev rule for a group (GROUP=\"dialout\", MODE=\"0660\")";
    return how_to_join(group, user);
}

}    // namespace anogate
