// The serial ports and CAN interfaces of a computer, read from its file system.
#pragma once
#include <sys/device_permission.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace anoctl {

/// A process that has a port open, or holds its lock.
struct Holder {
    int pid = 0;
    std::string program;    // its short name; "a process" when /proc does not show it
    bool operator==(const Holder&) const = default;
};

struct SerialPort {
    std::string device;       // "/dev/ttyUSB0"
    std::string driver;       // of the kernel: "ch341-uart"
    std::string stable;       // a name that does not depend on the order of plugging in; empty: there is none
    bool by_place = false;    // that name belongs to the USB socket, since the adapter has no serial number of its own
    std::string product;      // the product name of a USB device, as sent by it: not checked
    std::string usb;          // "1a86:7523"; empty: no USB device
    std::vector<Holder> holders;
    std::string missing;    // the permission that the asker lacks, and how to get it; empty: none is missing
};

struct CanInterface {
    std::string name;      // "can0"
    std::string driver;    // "gs_usb"; empty: a virtual interface
    bool up = false;
};

/// `root` is "/", or a folder with the same structure. Values that can't be read are empty.
std::vector<SerialPort> serial_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker);
std::vector<CanInterface> can_interfaces(const std::filesystem::path& root);

/// The processes that have `device` (a path that is no symbolic link) open, as far as we may see that in /proc, or hold its lock, which
/// everybody may see.
std::vector<Holder> holders_of(const std::filesystem::path& root, const std::string& device);

}    // namespace anoctl
