// The serial ports, HID devices of ANO and CAN interfaces of a computer, read from its file system.
#pragma once
#include <sys/device_permission.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace anoctl {

/// A process that has a port open, or holds its lock.
struct Holder {
    int pid = 0;
    std::string program;    // short name; "a process" if /proc does not show it
    bool operator==(const Holder&) const = default;
};

struct SerialPort {
    std::string device;       // "/dev/ttyUSB0"
    std::string driver;       // kernel driver: "ch341-uart"
    std::string stable;       // a name independent of the order of plugging in; empty: none
    bool by_place = false;    // `stable` is the name of the USB socket, because the adapter has no unique serial number
    std::string product;      // product name from the USB device, unchecked
    std::string usb;          // "1a86:7523"; empty: not a USB device
    std::vector<Holder> holders;
    std::string missing;    // the permission that `asker` lacks, and how to get it; empty: none
};

/// One of ANO's devices of class HID.
struct HidPort {
    std::string device;             // "/dev/hidraw0"
    std::string product;            // unchecked
    std::string usb;                // "0483:A005"
    bool carries_stream = false;    // otherwise no link can use it
    bool is_one_of_many = false;    // another one has the same id, so that only `device` distinguishes them
    std::vector<Holder> holders;
    std::string missing;    // as of a SerialPort
};

struct CanInterface {
    std::string name;      // "can0"
    std::string driver;    // "gs_usb"; empty: virtual interface
    bool up = false;
};

/// `root` is "/", or a folder with the same structure. Values that can't be read are empty.
std::vector<SerialPort> serial_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker);
std::vector<HidPort> hid_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker);
std::vector<CanInterface> can_interfaces(const std::filesystem::path& root);

/// The processes that have `device` (not a symbolic link) open or hold its lock. Locks are visible to every user, open files only
/// as far as /proc permits.
std::vector<Holder> holders_of(const std::filesystem::path& root, const std::string& device);

}    // namespace anoctl
