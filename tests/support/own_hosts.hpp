// A hosts file that only this process uses.
#pragma once
#include "temp_dir.hpp"

#include <sched.h>
#include <sys/mount.h>

#include <fstream>
#include <stdexcept>
#include <string>

namespace support {

/// While it exists, this thread and those that it starts resolve names with this file instead of /etc/hosts and a name server.
class OwnHosts {
public:
    explicit OwnHosts(const std::string& text) {
        set(text);
        std::ofstream{order_} << "hosts: files\n";
        if (::unshare(CLONE_NEWNS) != 0 || ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
            ::mount(hosts_.c_str(), "/etc/hosts", nullptr, MS_BIND, nullptr) != 0 ||
            ::mount(order_.c_str(), "/etc/nsswitch.conf", nullptr, MS_BIND, nullptr) != 0)
            throw std::runtime_error{"no mount namespace"};
    }
    ~OwnHosts() {
        ::umount2("/etc/nsswitch.conf", MNT_DETACH);
        ::umount2("/etc/hosts", MNT_DETACH);
    }
    OwnHosts(const OwnHosts&) = delete;
    OwnHosts& operator=(const OwnHosts&) = delete;

    void set(const std::string& text) { std::ofstream{hosts_} << text; }

private:
    TempDir dir_;
    std::string hosts_ = dir_ / "hosts", order_ = dir_ / "nsswitch.conf";
};

}    // namespace support
