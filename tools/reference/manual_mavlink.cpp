#include "manual.hpp"
#include "page.hpp"
#include "programs.hpp"

#include <config/help.hpp>
#include <config/keys.hpp>
#include <mavlink/mavlink_config.hpp>

namespace reference {
namespace {

using namespace anogate;

template <class Section>
void write_mavlink_keys(Page& page, Keys<Section> keys) {
    page.begin_list();
    for (const Key<Section>& key : keys)
        page.item(key.name, placeholder(key) + (key.required ? ", required" : ""), help_of(key, key.text_in(Section{})));
    page.end_list();
}

void write_mavlink_configuration(Page& page) {
    page.section("CONFIGURATION");
    page.text(
        "JSON with comments (// and /* */). An omitted key has its default; an unknown key is an error. --check lists the "
        "errors, one per line.");
    write_mavlink_keys(page, mavlink_keys());
    page.subsection("devices");
    page.text("A list of objects. Without it, the device 0xDC is shown as system 1.");
    write_mavlink_keys(page, mavlink_device_keys());
    page.begin_list();
    for (const MavlinkList& list : mavlink_device_lists()) page.item(list.name, list.placeholder, std::string{list.help});
    page.end_list();
    page.subsection("log");
    page.text("An object, as in anogate.json(5).");
}

}    // namespace

std::string anogate_mavlink_page() {
    Page page{"anogate-mavlink", 8, "devices of a gateway in MAVLink ground stations"};
    page.section("SYNOPSIS");
    page.synopsis("anogate-mavlink", "[options]");
    page.section("DESCRIPTION");
    page.text(
        "anogate-mavlink connects to a running anogated, and shows its devices to ground stations such as QGroundControl: "
        "telemetry, parameters, missions and commands over MAVLink 2 (and 1 for a station that sends it). A device is steered "
        "only if its entry in the configuration allows it.");
    page.paragraph();
    page.text("The program was tested with stations that follow the protocol, not with QGroundControl itself.");
    page.section("OPTIONS");
    page.begin_list();
    const Program program = anogate_mavlink_program();
    for (const Argument& option : program.commands.front().options) {
        std::string names;
        for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + name;
        page.item(names, option.value, option.help);
    }
    page.end_list();
    write_mavlink_configuration(page);
    page.section("FILES");
    page.begin_list();
    page.item("/etc/anogate/mavlink.json", "", "Configuration");
    page.item("/usr/share/doc/anogate-mavlink/config/mavlink.json", "", "Example");
    page.item("/etc/default/anogate-mavlink", "", "Environment variables of the service, one NAME=VALUE per line");
    page.end_list();
    page.section("EXIT STATUS");
    page.begin_list();
    page.item("0", "", "Stopped by SIGTERM or SIGINT");
    page.item("78", "", "The configuration or the command line is invalid");
    page.end_list();
    page.section("EXAMPLES");
    page.text("QGroundControl on a tablet in the same network:");
    page.literal("anogate-mavlink --udp 192.168.1.20:14550");
    page.text("A telemetry radio, and stations that connect over TCP:");
    page.literal("anogate-mavlink --serial /dev/ttyUSB1 --baud 57600 --tcp-listen 0.0.0.0:5760");
    page.see_also({"anoctl 1", "anogate.json 5", "anogated 8"});
    return page.str();
}

}    // namespace reference
