#include <link/serial/port_identity.hpp>

#include <algorithm>
#include <fstream>
#include <string_view>
#include <system_error>

namespace anogate {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view by_id = "/dev/serial/by-id/";

std::string first_line(const fs::path& file) {
    std::string line;
    std::getline(std::ifstream{file} >> std::ws, line);
    while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.pop_back();
    return line;
}

// Adapters that are not numbered have no serial number, or all the same one: a CP2102 has "0001".
bool is_number(const std::string& serial) { return serial != "0001" && serial.find_first_not_of('0') != serial.npos; }

std::string name_by_path(const fs::path& root, const std::string& tty) {
    std::string first;
    std::error_code ec;
    for (fs::directory_iterator i{root / "dev/serial/by-path", ec}, end; !ec && i != end; i.increment(ec)) {
        std::error_code none;
        const std::string name = "/dev/serial/by-path/" + i->path().filename().string();
        if (fs::read_symlink(i->path(), none).filename() == tty && (first.empty() || name < first)) first = name;
    }
    return first;
}

}    // namespace

PortIdentity port_identity(const fs::path& root, const std::string& device) {
    PortIdentity port;
    std::error_code ec;
    if (!device.starts_with('/')) return port;
    const std::string tty = fs::canonical(root / device.substr(1), ec).filename().string();
    if (ec) return port;
    port.device = "/dev/" + tty;
    port.by_path = name_by_path(root, tty);
    fs::path folder = fs::canonical(root / "sys/class/tty" / tty / "device", ec);
    for (; !ec && folder.has_relative_path() && folder.filename() != "devices"; folder = folder.parent_path()) {
        const std::string vendor = first_line(folder / "idVendor");
        if (vendor.empty()) continue;
        port.usb = vendor + ":" + first_line(folder / "idProduct");
        port.place = folder.filename().string();
        if (std::string serial = first_line(folder / "serial"); is_number(serial)) port.serial = std::move(serial);
        break;
    }
    return port;
}

// The ports of one adapter are not twins of each other.
std::vector<std::string> twins_of(const fs::path& root, const PortIdentity& port) {
    std::vector<std::string> twins;
    if (port.usb.empty()) return twins;
    std::error_code ec;
    for (fs::directory_iterator i{root / "sys/class/tty", ec}, end; !ec && i != end; i.increment(ec)) {
        const PortIdentity other = port_identity(root, "/dev/" + i->path().filename().string());
        if (other.usb == port.usb && other.serial == port.serial && other.place != port.place) twins.push_back(other.device);
    }
    std::sort(twins.begin(), twins.end());
    return twins;
}

void SocketWatch::opened(const fs::path& root, const std::string& device) {
    const PortIdentity port = port_identity(root, device);
    if (from_.empty()) from_ = port.place;
    to_ = port.place;
    twin_.clear();
    beside_.clear();
    if (awaits_twin()) look_for_twin(root, device);
    if (!device.starts_with(by_id)) return;
    if (const auto twins = twins_of(root, port); !twins.empty()) beside_ = twins.front();
}

void SocketWatch::look_for_twin(const fs::path& root, const std::string& device) {
    if (const auto twins = twins_of(root, port_identity(root, device)); !twins.empty()) twin_ = twins.front();
}

std::string fault_of_by_id(const fs::path& root, const std::string& device) {
    if (!device.starts_with(by_id)) return {};
    const PortIdentity port = port_identity(root, device);
    const bool is_one_of_many = port.usb.empty() ? device.starts_with(std::string{by_id} + "usb-1a86_") && port.device.empty()
                                                 : port.is_one_of_many() || !twins_of(root, port).empty();
    if (!is_one_of_many) return {};
    return "its adapter has no serial number, so after replugging this name may belong to another adapter of the same model: "
           "use " +
           (port.by_path.empty() ? "the name in /dev/serial/by-path/ (anoctl ports)" : port.by_path) +
           ", which belongs to the USB port";
}

}    // namespace anogate
