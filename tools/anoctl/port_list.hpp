// The serial ports and CAN interfaces of a computer, read from its file system.
#pragma once
#include <link/device_permission.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace anoctl {

/// A process that has a port open, or holds its lock.
struct Holder {
    int pid = 0;
    std::string program;    // its short name; "a process" where /proc does not say
    bool operator==(const Holder&) const = default;
};

struct SerialPort {
    std::string device;     // "/dev/ttyUSB0"
    std::string driver;     // the kernel's: "ch341-uart"
    std::string stable;     // a name that stays when devices are plugged in another order; empty: there is none
    std::string product;    // what a USB device calls itself, as it says it: not checked
    std::string usb;        // "1a86:7523"; empty: no USB device
    std::vector<Holder> holders;
    std::string missing;    // which permission the asker lacks, and how to get it; empty: none
};

struct CanInterface {
    std::string name;      // "can0"
    std::string driver;    // "gs_usb"; empty: a virtual one
    bool up = false;
};

/// `root` is "/", or a tree that looks like it. What can't be read is left empty.
std::vector<SerialPort> serial_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker);
std::vector<CanInterface> can_interfaces(const std::filesystem::path& root);

/// Who has `device` (a path that is no link) open, as far as /proc shows it to us, or holds its lock, which it shows to everybody.
std::vector<Holder> holders_of(const std::filesystem::path& root, const std::string& device);

}    // namespace anoctl
