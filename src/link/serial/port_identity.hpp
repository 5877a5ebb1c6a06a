// The USB adapter of a serial port, and whether it can be distinguished from another adapter of its kind.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace anogate {

struct PortIdentity {
    std::string device;     // "/dev/ttyUSB0"
    std::string usb;        // "1a86:7523"; empty: no USB device
    std::string serial;     // its serial number; empty: none, or one that all adapters of its kind have
    std::string place;      // the USB socket: "1-1.2"; empty: no USB device
    std::string by_path;    // its name in /dev/serial/by-path, which belongs to the socket; empty: none

    /// Whether names in /dev/serial/by-id may lead to another adapter after re-plugging, because adapters of this kind can't be
    /// distinguished.
    bool is_one_of_many() const noexcept { return !usb.empty() && serial.empty(); }
};

/// The identity of `device`, which may be a symbolic link. `root` is "/", or a folder with the same structure. Fields that can't
/// be read are empty.
PortIdentity port_identity(const std::filesystem::path& root, const std::string& device);

/// The other connected ports of the same kind that differ from `port` only by their USB sockets: "/dev/ttyUSB1".
std::vector<std::string> twins_of(const std::filesystem::path& root, const PortIdentity& port);

/// Detects that a name leads to an adapter in another USB socket than before while a twin is connected.
class SocketWatch {
public:
    /// To be called each time after `device` is opened.
    void opened(const std::filesystem::path& root, const std::string& device);
    /// The adapter is in another socket than the first, and no twin was connected: it may be the twin itself, whose other one
    /// follows.
    bool awaits_twin() const noexcept { return from_ != to_ && twin_.empty(); }
    /// Looks again for a twin.
    void look_for_twin(const std::filesystem::path& root, const std::string& device);
    /// The sockets of the adapter that was opened first and of the present one.
    const std::string& from() const noexcept { return from_; }
    const std::string& to() const noexcept { return to_; }
    /// A connected twin of the present adapter, if that is in another socket than the first; empty: no change was detected.
    const std::string& twin() const noexcept { return twin_; }
    /// A twin that was connected when a name in /dev/serial/by-id was opened; empty: none. The name may have led to the other one
    /// before this program started.
    const std::string& beside() const noexcept { return beside_; }

private:
    std::string from_, to_, twin_, beside_;
};

/// The reason why `device`, a name in /dev/serial/by-id, may lead to another adapter, and the name to use; empty: it does not, or
/// it is not connected and its name does not show it.
std::string fault_of_by_id(const std::filesystem::path& root, const std::string& device);

}    // namespace anogate
