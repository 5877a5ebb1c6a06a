#include "port_list.hpp"

#include <link/hid/hid_device.hpp>
#include <link/serial/port_identity.hpp>

#include <linux/if_arp.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <tuple>

namespace anoctl {
namespace {

namespace fs = std::filesystem;

using HoldersByDevice = std::map<std::string, std::vector<Holder>>;

/// The absolute `path` in the tree below `root`.
fs::path below(const fs::path& root, const std::string& path) { return root / path.substr(1); }

/// The first line of a small file; empty if it is not readable.
std::string line_of(const fs::path& file) {
    std::string line;
    std::getline(std::ifstream{file} >> std::ws, line);
    while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.pop_back();
    return line;
}

/// The file name of the target of the symbolic link `path`; empty: not a symbolic link.
std::string target_name(const fs::path& path) {
    std::error_code none;
    return fs::read_symlink(path, none).filename().string();
}

std::vector<fs::path> entries(const fs::path& folder) {
    std::vector<fs::path> all;
    std::error_code ec;
    for (fs::directory_iterator i{folder, ec}, end; !ec && i != end; i.increment(ec)) all.push_back(i->path());
    return all;
}

std::optional<int> number_in(std::string_view text) {
    int number = 0;
    const auto [last, bad] = std::from_chars(text.data(), text.data() + text.size(), number);
    return bad == std::errc{} && last == text.data() + text.size() ? std::optional{number} : std::nullopt;
}

/// Sort key: ttyUSB2 before ttyUSB10.
auto in_order(const std::string& name) {
    const std::size_t digits = name.find_last_not_of("0123456789") + 1;
    return std::tuple{name.substr(0, digits), number_in(std::string_view{name}.substr(digits)).value_or(-1), name};
}

// Since Linux 6.5, the devices "port" and "ctrl" are between a UART and its driver.
bool is_between(const std::string& driver) { return driver == "port" || driver == "ctrl"; }

/// Sets the properties from sysfs: from the folder of the port, then from its parents.
void describe(const fs::path& device, SerialPort& port) {
    std::error_code ec;
    fs::path folder = fs::canonical(device, ec);
    for (; !ec && folder.has_relative_path() && folder.filename() != "devices"; folder = folder.parent_path()) {
        if (const std::string driver = target_name(folder / "driver"); port.driver.empty() && !is_between(driver))
            port.driver = driver;
        const std::string vendor = line_of(folder / "idVendor");
        if (vendor.empty()) continue;
        port.usb = vendor + ":" + line_of(folder / "idProduct");
        port.product = line_of(folder / "product");
        return;
    }
}

// The 8250 driver creates its ports (ttyS0 to ttyS3) even without a UART.
bool is_phantom(const fs::path& tty) { return line_of(tty / "type") == "0"; }

// Adapters without a unique serial number have the same name in by-id, which udev links to the one plugged in last.
std::string stable_name(const fs::path& root, const std::string& name, bool by_place) {
    if (by_place)
        if (std::string place = anogate::port_identity(root, "/dev/" + name).by_path; !place.empty()) return place;
    for (const char* folder : {"/dev/serial/by-id", "/dev/serial/by-path"}) {
        std::vector<std::string> names;
        for (const fs::path& link : entries(below(root, folder)))
            if (target_name(link) == name) names.push_back(std::string{folder} + "/" + link.filename().string());
        if (!names.empty()) return *std::min_element(names.begin(), names.end());
    }
    for (const char* alias : {"/dev/serial0", "/dev/serial1"})    // on a Raspberry Pi
        if (target_name(below(root, alias)) == name) return alias;
    return {};
}

// --- processes that use devices ---------------------------------------------------------------------------------------

void add_holder(const fs::path& root, int pid, std::vector<Holder>& holders) {
    const fs::path process = below(root, "/proc/" + std::to_string(pid));
    std::error_code ec;
    if (pid <= 0 || !fs::exists(process, ec)) return;
    const std::string program = line_of(process / "comm");
    const Holder holder{pid, program.empty() ? "a process" : program};
    if (std::find(holders.begin(), holders.end(), holder) == holders.end()) holders.push_back(holder);
}

/// Processes of the current user, or all for root.
void add_openers(const fs::path& root, HoldersByDevice& devices) {
    for (const fs::path& process : entries(below(root, "/proc"))) {
        const auto pid = number_in(process.filename().string());
        if (!pid) continue;
        for (const fs::path& fd : entries(process / "fd")) {
            std::error_code none;
            const auto device = devices.find(fs::read_symlink(fd, none).string());
            if (device != devices.end()) add_holder(root, *pid, device->second);
        }
    }
}

/// flock() locks, as anogated uses: "1: FLOCK  ADVISORY  WRITE 812 00:05:123 0 EOF". Readable for every user.
void add_lockers(const fs::path& root, HoldersByDevice& devices) {
    std::map<std::string, std::vector<Holder>*> by_inode;
    for (auto& [device, holders] : devices) {
        struct stat s {};
        if (::stat(below(root, device).c_str(), &s) != 0) continue;
        std::array<char, 64> text{};
        std::snprintf(text.data(), text.size(), "%02x:%02x:%llu", major(s.st_dev), minor(s.st_dev),
                      static_cast<unsigned long long>(s.st_ino));
        by_inode[text.data()] = &holders;
    }
    std::ifstream locks{below(root, "/proc/locks")};
    for (std::string line; std::getline(locks, line);) {
        std::istringstream words{line};
        const std::vector<std::string> w{std::istream_iterator<std::string>{words}, {}};
        if (w.size() < 6 || w[1] != "FLOCK") continue;    // "->" in w[1]: the process waits for a lock
        const auto device = by_inode.find(w[5]);
        if (device != by_inode.end()) add_holder(root, number_in(w[4]).value_or(0), *device->second);
    }
}

/// Lock files, as minicom and pppd use them. Those of ended processes are ignored.
void add_lock_files(const fs::path& root, HoldersByDevice& devices) {
    for (auto& [device, holders] : devices) {
        const std::string name = fs::path{device}.filename().string();
        for (const char* folder : {"/run/lock/LCK..", "/var/lock/LCK.."})
            add_holder(root, number_in(line_of(below(root, folder + name))).value_or(0), holders);
    }
}

void add_holders(const fs::path& root, HoldersByDevice& devices) {
    add_openers(root, devices);
    add_lockers(root, devices);
    add_lock_files(root, devices);
    for (auto& [device, holders] : devices)
        std::sort(holders.begin(), holders.end(), [](const Holder& a, const Holder& b) { return a.pid < b.pid; });
}

}    // namespace

std::vector<Holder> holders_of(const fs::path& root, const std::string& device) {
    HoldersByDevice devices{{device, {}}};
    add_holders(root, devices);
    return devices[device];
}

std::vector<SerialPort> serial_ports(const fs::path& root, const anogate::DeviceUser& asker) {
    std::vector<SerialPort> ports;
    HoldersByDevice devices;
    for (const fs::path& tty : entries(below(root, "/sys/class/tty"))) {
        const std::string name = tty.filename().string();
        std::error_code ec;
        const bool has_device = fs::exists(tty / "device", ec);    // consoles and pseudo-terminals have no device
        if ((!has_device && !name.starts_with("rfcomm")) || is_phantom(tty)) continue;
        SerialPort port;
        port.device = "/dev/" + name;
        describe(tty / "device", port);
        const auto identity = anogate::port_identity(root, port.device);
        port.by_place = identity.is_one_of_many() || !anogate::twins_of(root, identity).empty();
        port.stable = stable_name(root, name, port.by_place);
        port.missing = anogate::missing_permission(root, port.device, asker);
        devices[port.device];
        ports.push_back(std::move(port));
    }
    add_holders(root, devices);
    for (SerialPort& port : ports) port.holders = devices[port.device];
    std::sort(ports.begin(), ports.end(), [](const auto& a, const auto& b) { return in_order(a.device) < in_order(b.device); });
    return ports;
}

std::vector<HidPort> hid_ports(const fs::path& root, const anogate::DeviceUser& asker) {
    std::vector<HidPort> ports;
    HoldersByDevice devices;
    for (const anogate::hid::Device& device : anogate::hid::devices(root)) {
        const auto is_of = [&](const anogate::hid::UsbId& id) { return id.matches(device.id); };
        if (std::none_of(std::begin(anogate::hid::ano_ids), std::end(anogate::hid::ano_ids), is_of)) continue;
        std::array<char, 16> usb{};
        std::snprintf(usb.data(), usb.size(), "%04X:%04X", device.id.vendor, device.id.product.value_or(0));
        devices[device.path];
        ports.push_back({device.path,
                         device.name,
                         usb.data(),
                         device.reports.has_value(),
                         false,
                         {},
                         anogate::missing_permission(root, device.path, asker)});
    }
    add_holders(root, devices);
    for (HidPort& port : ports) {
        port.holders = devices[port.device];
        port.is_one_of_many = std::count_if(ports.begin(), ports.end(),
                                            [&](const HidPort& other) { return other.usb == port.usb; }) > 1;
    }
    return ports;
}

std::vector<CanInterface> can_interfaces(const fs::path& root) {
    std::vector<CanInterface> all;
    for (const fs::path& folder : entries(below(root, "/sys/class/net"))) {
        if (line_of(folder / "type") != std::to_string(ARPHRD_CAN)) continue;
        const std::string flags = line_of(folder / "flags");    // for example 0x40081
        constexpr unsigned long is_up = 1;
        all.push_back({folder.filename().string(), target_name(folder / "device/driver"),
                       (std::strtoul(flags.c_str(), nullptr, 16) & is_up) != 0});
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return in_order(a.name) < in_order(b.name); });
    return all;
}

}    // namespace anoctl
