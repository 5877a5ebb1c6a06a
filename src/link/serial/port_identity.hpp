// Which USB adapter a serial port is, and whether it can be told from another one of its kind.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace anogate {

struct PortIdentity {
    std::string device;     // "/dev/ttyUSB0"
    std::string usb;        // "1a86:7523"; empty: no USB device
    std::string serial;     // its serial number; empty: it has none, or one that all of its kind have
    std::string place;      // the USB socket: "1-1.2"; empty: no USB device
    std::string by_path;    // its name in /dev/serial/by-path, which stays with the socket; empty: there is none

    /// Names in /dev/serial/by-id may lead to another adapter after plugging: nothing tells one from another.
    bool is_one_of_many() const noexcept { return !usb.empty() && serial.empty(); }
};

/// Of `device`, which may be a symbolic link. `root` is "/", or a folder with the same structure. Fields that can't be read are empty.
PortIdentity port_identity(const std::filesystem::path& root, const std::string& device);

/// The other ports of the same kind that are plugged in, when nothing but their sockets tells them apart: "/dev/ttyUSB1".
std::vector<std::string> twins_of(const std::filesystem::path& root, const PortIdentity& port);

/// Notices that a name leads to an adapter in another USB socket than before while a twin is plugged in.
class SocketWatch {
public:
    /// To be called each time `device` was opened.
    void opened(const std::filesystem::path& root, const std::string& device);
    /// The sockets of the adapter that was opened first and of the present one.
    const std::string& from() const noexcept { return from_; }
    const std::string& to() const noexcept { return to_; }
    /// Empty: the adapter is the first one, as far as can be known.
    const std::string& twin() const noexcept { return twin_; }

private:
    std::string from_, to_, twin_;
};

/// Why `device`, a name in /dev/serial/by-id, may lead to another adapter, and which name to use; empty: it does not, or it is not
/// plugged in and its name does not show it.
std::string fault_of_by_id(const std::filesystem::path& root, const std::string& device);

}    // namespace anogate
