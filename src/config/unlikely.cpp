#include <config/key_facts.hpp>
#include <config/unlikely.hpp>
#include <config/values.hpp>

namespace anogate {
namespace {

bool is_pattern(const std::string& name) { return name.find_first_of("*?[") != name.npos; }

/// The probable full path of a port: names in /dev/serial/by-id begin with the bus.
std::string path_of(const std::string& name) {
    if (name.starts_with("dev/")) return "/" + name;
    return (name.starts_with("usb-") ? "/dev/serial/by-id/" : "/dev/") + name;
}

}    // namespace

std::string fault_of_device(const std::string& device) {
    const std::string what = "'device' " + in_quotes(device);
    if (is_pattern(device))
        return what + " is a pattern, but a link is one port: use its name in /dev/serial/by-id/, which does not change";
    const bool port = device.starts_with("tty") || device.starts_with("serial") || device.starts_with("usb-") ||
                      device.starts_with("rfcomm") || device.starts_with("dev/");
    if (port) return what + " is not the path of a port (did you mean '" + path_of(device) + "'?)";
    if (device.find('/') == device.npos) return what + " is not the path of a port, such as /dev/ttyUSB0";
    const std::size_t colon = device.rfind(':');
    if (colon != device.npos && parse_number(device.substr(colon + 1)))
        return what + " ends with a number (did you mean '" + device.substr(0, colon) +
               "' with baud=" + device.substr(colon + 1) + "?)";
    return {};
}

std::string fault_of_interface(const std::string& interface) {
    if (!is_pattern(interface)) return {};
    return "'interface' " + in_quotes(interface) + " is a pattern, but a link is one interface, such as can0";
}

}    // namespace anogate
