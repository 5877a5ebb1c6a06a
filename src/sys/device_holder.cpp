#include <sys/device_holder.hpp>

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

// The fdinfo of a master contains the number of its terminal: "tty-index: 5" means /dev/pts/5.
bool has_master_of(const fs::path& process, const fs::path& device) {
    if (device.parent_path() != "/dev/pts") return false;
    std::error_code ec;
    for (fs::directory_iterator infos{process / "fdinfo", ec}, end; !ec && infos != end; infos.increment(ec)) {
        std::ifstream info{infos->path()};
        for (std::string word, index; info >> word;)
            if (word == "tty-index:" && info >> index && index == device.filename()) return true;
    }
    return false;
}

}    // namespace

bool DeviceHolder::is_there() const {
    std::error_code ec;
    return fs::exists("/proc/" + std::to_string(pid), ec);
}

// Init is skipped: it holds the devices that a service has stored for its restart.
std::optional<DeviceHolder> device_holder(const std::string& device, OtherSide other_side) {
    constexpr int init = 1;
    std::error_code ec;
    const fs::path real = fs::canonical(device, ec);
    if (ec) return std::nullopt;
    for (fs::directory_iterator processes{"/proc", ec}, end; !ec && processes != end; processes.increment(ec)) {
        const std::string pid = processes->path().filename();
        int number = 0;
        const auto [last, bad] = std::from_chars(pid.data(), pid.data() + pid.size(), number);
        if (bad != std::errc{} || last != pid.data() + pid.size() || number == ::getpid() || number == init) continue;
        if (!has_open(processes->path(), real)) continue;
        if (other_side == OtherSide::does_not_count && has_master_of(processes->path(), real)) continue;
        DeviceHolder holder{number, "a process"};
        std::ifstream{processes->path() / "comm"} >> holder.program;
        return holder;
    }
    return std::nullopt;
}

}    // namespace anogate
