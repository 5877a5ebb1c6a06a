#include "manual.hpp"
#include "page.hpp"
#include "programs.hpp"

#include <config/link_kind.hpp>
#include <link/kinds.hpp>

namespace reference {
namespace {

std::string joined(const std::vector<std::string>& words, std::string_view between) {
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : std::string{between}) + word;
    return all;
}

void write_options(Page& page, const Command& command) {
    page.begin_list();
    for (const Argument& operand : command.operands) page.item("", operand.value, operand.help);
    for (const Argument& option : command.options) page.item(joined(option.names, ", "), option.value, option.help);
    page.end_list();
}

std::string operands(const Command& command) {
    std::string all = "[options]";
    for (const Argument& operand : command.operands) all += " " + operand.value;
    return all;
}

}    // namespace

std::string anogated_page() {
    const Program program = anogated_program();
    Page page{"anogated", 8, "gateway for the ANO V8 protocol"};
    page.section("SYNOPSIS");
    page.synopsis("anogated", "[options] [LINK ...]");
    page.section("DESCRIPTION");
    page.text(
        "anogated connects serial ports, CAN buses and UDP peers that use ANO V8 into one network, and forwards each frame to "
        "its destination address.");
    page.paragraph();
    page.text(
        "Without LINK and --config it reads /etc/anogate/anogate.json, see anogate.json(5). If a device is missing, anogated "
        "waits for it. For each error in the configuration it prints one line with the location and a suggestion.");
    page.section("OPTIONS");
    write_options(page, program.commands.front());
    page.section("LINKS");
    page.text(
        "LINK is KIND:ADDRESS[,KEY=VALUE...]; the address ends at the first comma after KIND:. A key without a value means true. "
        "The keys are those of the configuration file; a key inside an object is written with a dot: send.deny=0xB0+firmware.");
    page.begin_list();
    for (const anogate::LinkKind* kind : anogate::link_kinds())
        page.item(std::string{kind->name} + ":" + std::string{kind->example}, "", kind->help);
    page.end_list();
    page.section("SIGNALS");
    page.begin_list();
    page.item("SIGTERM, SIGINT", "",
              "Stop reading, send queued frames for at most 0.5 s, and exit. A second signal exits immediately");
    page.item("SIGUSR1", "", "Write a short status to the log");
    page.end_list();
    page.section("ENVIRONMENT");
    page.begin_list();
    page.item("XDG_RUNTIME_DIR", "", "Folder of the control socket when not run by root");
    page.item("NO_COLOR", "", "Disable colors in the log on a terminal");
    page.end_list();
    page.section("FILES");
    page.begin_list();
    page.item("/etc/anogate/anogate.json", "", "Configuration of the service");
    page.item("/etc/anogate/NAME.json", "", "Configuration of anogated@NAME.service, an additional gateway on this computer");
    page.item("/etc/default/anogate", "", "Environment variables of the service, one NAME=VALUE per line");
    page.item("/run/anogate/control.sock", "", "Control socket; for anogated@NAME.service: /run/anogate-NAME/control.sock");
    page.end_list();
    page.section("EXIT STATUS");
    page.begin_list();
    page.item("0", "", "Stopped by SIGTERM or SIGINT");
    page.item("1", "", "A link with \"required\" was not up within 10 s");
    page.item("78", "", "The configuration or the command line is invalid");
    page.end_list();
    page.section("EXAMPLES");
    page.text("Connect a flight controller on a USB serial port with ground stations on UDP:");
    page.literal("anogated serial:/dev/ttyUSB0,baud=500000,profile=vendor udp-listen:0.0.0.0:12333");
    page.text("Print the equivalent configuration file:");
    page.literal("anogated serial:/dev/ttyUSB0,baud=500000,profile=vendor udp-listen:0.0.0.0:12333 --print-config");
    page.see_also({"anoctl 1", "anogate.json 5", "anogate-api 7"});
    return page.str();
}

std::string anoctl_page() {
    const Program program = anoctl_program();
    Page page{"anoctl", 1, "tool for ANO V8 frames and the anogate gateway"};
    page.section("SYNOPSIS");
    page.synopsis("anoctl", "command [options] [operands]");
    page.section("DESCRIPTION");
    page.text(
        "anoctl decodes, encodes and shows ANO V8 frames, and controls a running gateway. On a terminal, output has columns and "
        "units; in a file or pipe, it has the names and numbers that encode accepts. With --json, before or after the command, "
        "each line is one JSON object.");
    page.section("COMMANDS");
    for (const Command& command : program.commands) {
        page.subsection(command.name);
        page.text(command.help + ":");
        page.literal("anoctl " + command.name + " " + operands(command));
        write_options(page, command);
    }
    page.section("ENVIRONMENT");
    page.begin_list();
    page.item("NO_COLOR", "", "Disable colors");
    page.end_list();
    page.section("EXIT STATUS");
    page.begin_list();
    page.item("0", "", "Success");
    page.item("1", "", "Failure: no response, request refused, or input that is not a valid frame");
    page.item("2", "", "Usage error");
    page.end_list();
    page.section("EXAMPLES");
    page.literal(
        "anoctl decode AB DB FE A0 0C 00 02 74 65 73 74 46 75 6E 20 4F 4B 21 F6 1C\n"
        "anoctl encode euler rol=1.5 pit=-2 yaw=90 --from 0xDC --to 0xFE\n"
        "anoctl monitor serial:/dev/ttyUSB0,baud=500000 --id euler power\n"
        "anoctl ports --detect /dev/ttyUSB0");
    page.see_also({"anogate.json 5", "anogate-api 7", "anogated 8"});
    return page.str();
}

}    // namespace reference
