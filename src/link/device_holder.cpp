#include <link/device_holder.hpp>

#include <unistd.h>
#include <charconv>
#include <filesystem>
#include <fstream>

namespace anogate {
namespace {

namespace fs = std::filesystem;

bool has_open(const fs::path& process, const fs::path& device) {
    std::error_code ec;
    for (fs::directory_iterator fds{process / "fd", ec}, end; !ec && fds != end; fds.increment(ec)) {
        std::error_code unreadable;
        if (fs::read_symlink(fds->path(), unreadable) == device) return true;
    }
    return false;
}

}    // namespace

std::string device_holder(const std::string& device) {
    std::error_code ec;
    const fs::path real = fs::canonical(device, ec);
    if (ec) return {};
    for (fs::directory_iterator processes{"/proc", ec}, end; !ec && processes != end; processes.increment(ec)) {
        const std::string pid = processes->path().filename();
        int number = 0;
        const auto [last, bad] = std::from_chars(pid.data(), pid.data() + pid.size(), number);
        if (bad != std::errc{} || last != pid.data() + pid.size() || number == ::getpid()) continue;
        if (!has_open(processes->path(), real)) continue;
        std::string name = "a process";
        std::ifstream{processes->path() / "comm"} >> name;
        return name + " (pid " + pid + ")";
    }
    return {};
}

}    // namespace anogate
