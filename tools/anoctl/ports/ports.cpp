// anoctl ports: lists the serial ports, HID devices of ANO and CAN interfaces.
#include "ports.hpp"
#include <anoctl/anoctl.hpp>
#include "can_figures.hpp"
#include "detect_rate.hpp"
#include "port_list.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <sstream>
#include <string>
#include <utility>

namespace anoctl {
namespace {

using ano::Json;

constexpr std::size_t page_width = 80;

/// `text` in lines of at most 80 columns, each indented by `indent`. Words are never split, so that names can be copied.
std::string paragraph(const std::string& text, std::size_t indent) {
    std::istringstream words{text};
    std::string all, line;
    const auto end_line = [&] {
        if (!line.empty()) all += line + "\n";
        line.clear();
    };
    for (std::string word; words >> word;) {
        if (!line.empty() && line.size() + 1 + word.size() > page_width) end_line();
        if (line.empty()) line = std::string(indent + word.size() > page_width ? 0 : indent, ' ') + word;
        else line += " " + word;
    }
    end_line();
    return all;
}

/// Text from a device, with control characters replaced by '?'.
std::string safe(const std::string& text) {
    std::string out = ano::to_utf8({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, ano::Encoding::utf8);
    for (std::size_t at = 0; at < out.size(); ++at)
        if (const std::size_t n = ano::control_size(out, at); n > 0) out.replace(at, n, "?");
    return out;
}

template <class Port>
std::string users_and_permission(const Port& port) {
    std::string all;
    for (const Holder& h : port.holders)
        all += paragraph("in use by " + safe(h.program) + " (pid " + std::to_string(h.pid) + ")", 4);
    if (!port.missing.empty()) all += paragraph("permission denied: " + port.missing, 4);
    return all;
}

std::string format_port(const SerialPort& port) {
    std::string first = port.device + "  " + (port.driver.empty() ? "no driver" : port.driver);
    if (!port.product.empty()) first += "  " + safe(port.product);
    if (!port.usb.empty()) first += "  (" + port.usb + ")";
    std::string all = paragraph(first, 0);
    if (!port.stable.empty()) all += paragraph(safe(port.stable), 4);
    if (port.by_place)
        all += paragraph(
            "named by USB socket: the adapter has no unique serial number, so its name in by-id can refer to another adapter "
            "after replugging",
            4);
    return all + users_and_permission(port);
}

template <class Port>
Json holders_json(const Port& port) {
    Json holders = Json::array();
    for (const Holder& h : port.holders) holders.push_back({{"pid", h.pid}, {"program", safe(h.program)}});
    return holders;
}

Json as_json(const SerialPort& port) {
    return {{"kind", "serial"},
            {"device", port.device},
            {"stable", safe(port.stable)},
            {"by_place", port.by_place},
            {"driver", port.driver},
            {"usb", port.usb},
            {"product", safe(port.product)},
            {"holders", holders_json(port)},
            {"permission", port.missing.empty()},
            {"missing", port.missing}};
}

/// The LINK for a device: by its id, which replugging does not change, unless another device has the same.
std::string link_of(const HidPort& port) { return "hid:" + (port.is_one_of_many ? port.device : port.usb); }

std::string format_port(const HidPort& port) {
    std::string all = paragraph(port.device + "  HID  " + safe(port.product) + "  (" + port.usb + ")", 0);
    if (port.carries_stream) all += paragraph("link: " + link_of(port), 4);
    else all += paragraph("carries no byte stream", 4);
    return all + users_and_permission(port);
}

Json as_json(const HidPort& port) {
    return {{"kind", "hid"},
            {"device", port.device},
            {"link", port.carries_stream ? Json(link_of(port)) : Json()},
            {"usb", port.usb},
            {"product", safe(port.product)},
            {"holders", holders_json(port)},
            {"permission", port.missing.empty()},
            {"missing", port.missing}};
}

std::string format_port(const CanInterface& can, const CanFigures& figures) {
    std::string first = can.name + "  " + (can.driver.empty() ? "virtual" : can.driver) +
                        (can.up ? "  up" : "  down; to bring it up:");
    if (can.up && !figures.bus.empty()) first += std::string{"  "} + std::string{figures.bus};
    if (figures.bitrate != 0) first += "  " + std::to_string(figures.bitrate) + " bit/s";
    if (figures.data_bitrate != 0) first += ", data " + std::to_string(figures.data_bitrate) + " bit/s";
    std::string all = paragraph(first, 0);
    const std::string rate = can.driver.empty() ? "" : " type can bitrate 500000 restart-ms 100";
    if (!can.up) all += "    sudo ip link set " + can.name + " up" + rate + "\n";
    return all;
}

Json as_json(const CanInterface& can, const CanFigures& figures) {
    return {{"kind", "can"},
            {"interface", can.name},
            {"driver", can.driver},
            {"up", can.up},
            {"bus", figures.bus},
            {"bitrate", figures.bitrate},
            {"data_bitrate", figures.data_bitrate}};
}

}    // namespace

void write_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker, bool json, std::ostream& out) {
    const auto serial = serial_ports(root, asker);
    for (const SerialPort& port : serial) {
        if (json) out << ano::json_text(as_json(port)) << '\n';
        else out << format_port(port);
    }
    const auto hid = hid_ports(root, asker);
    for (const HidPort& port : hid) {
        if (json) out << ano::json_text(as_json(port)) << '\n';
        else out << format_port(port);
    }
    const auto can = can_interfaces(root);
    for (const CanInterface& interface : can) {
        const CanFigures figures = root == "/" ? can_figures(interface.name) : CanFigures{};
        if (json) out << ano::json_text(as_json(interface, figures)) << '\n';
        else out << format_port(interface, figures);
    }
    if (json) return;
    if (serial.empty() && hid.empty())
        out << paragraph("no serial port found; check that the adapter is plugged in (kernel messages: sudo dmesg)", 0);
    if (can.empty()) out << "no CAN interface found\n";
    if (asker.uid != 0 && !serial.empty())
        out << paragraph("Shown are your own programs and programs that lock the port; with sudo, all programs.", 0);
}

namespace {

struct Ports {
    std::string detect;
    bool json = false;

    int run(Streams& streams) const {
        if (!detect.empty()) return detect_rate(detect, json, streams);
        write_ports("/", anogate::DeviceUser::this_process(), json, streams.out);
        return fine;
    }
};

}    // namespace

Run add_ports(Options& options) {
    const auto self = std::make_shared<Ports>();
    options.push_back(
        {"--detect", &self->detect, "PORT", "Listen at the usual baud rates and report the one with valid frames; send nothing"});
    options.push_back({"--json", &self->json, "", "Print one JSON object per port and line"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
