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

void put_options(Page& page, const Command& command) {
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
        "Joins serial ports, CAN buses and UDP peers that speak ANO V8 into one network, and carries each frame to where its "
        "destination address is.");
    page.paragraph();
    page.text(
        "Without a LINK and without --config it reads /etc/anogate/anogate.json, see anogate.json(5). A device that is absent "
        "is waited for; a fault in the configuration is one line that says where, and what was meant.");
    page.section("OPTIONS");
    put_options(page, program.commands.front());
    page.section("LINKS");
    page.text(
        "LINK is KIND:ADDRESS[,KEY=VALUE...]; everything before the first comma behind KIND: is the address. A key alone means "
        "true. The keys are those of the configuration file, with a dot where they stand in an object of their own: "
        "send.deny=0xB0+firmware.");
    page.begin_list();
    for (const anogate::LinkKind* kind : anogate::link_kinds())
        page.item(std::string{kind->name} + ":" + std::string{kind->example}, "", kind->help);
    page.end_list();
    page.section("SIGNALS");
    page.begin_list();
    page.item("SIGTERM, SIGINT", "",
              "Reads no more, lets what waits leave for at most 0.5 s, and exits. A second one ends it at once");
    page.item("SIGUSR1", "", "Writes a short form of the status to the log");
    page.end_list();
    page.section("ENVIRONMENT");
    page.begin_list();
    page.item("XDG_RUNTIME_DIR", "", "Where the control socket of an ordinary user is");
    page.item("NO_COLOR", "", "Ends the colours of the log on a terminal");
    page.end_list();
    page.section("FILES");
    page.begin_list();
    page.item("/etc/anogate/anogate.json", "", "The configuration of the service");
    page.item("/etc/anogate/NAME.json", "", "That of anogated@NAME.service, a further gateway on this computer");
    page.item("/etc/default/anogate", "", "Variables of the environment for the service, one NAME=VALUE a line");
    page.item("/run/anogate/control.sock", "", "The control interface; anogated@NAME.service has /run/anogate-NAME/control.sock");
    page.end_list();
    page.section("EXIT STATUS");
    page.begin_list();
    page.item("0", "", "Ended by SIGTERM or SIGINT");
    page.item("1", "", "A link with \"required\" was not up within 10 s");
    page.item("78", "", "The configuration or the command line has a fault");
    page.end_list();
    page.section("EXAMPLES");
    page.text("A flight controller at a USB serial port, ground stations by UDP:");
    page.literal("anogated serial:/dev/ttyUSB0,baud=500000,profile=vendor udp-listen:0.0.0.0:12333");
    page.text("The same as a configuration file:");
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
        "Reads, makes and shows frames of ANO V8, and asks a gateway that runs. On a terminal there are columns and units; in a "
        "file or a pipe there are the names and numbers that encode takes. With --json, before or behind the command, each line "
        "is one JSON object.");
    page.section("COMMANDS");
    for (const Command& command : program.commands) {
        page.subsection(command.name);
        page.text(command.help + ":");
        page.literal("anoctl " + command.name + " " + operands(command));
        put_options(page, command);
    }
    page.section("ENVIRONMENT");
    page.begin_list();
    page.item("NO_COLOR", "", "Ends colours");
    page.end_list();
    page.section("EXIT STATUS");
    page.begin_list();
    page.item("0", "", "All went well");
    page.item("1", "", "The work failed: there is no answer, it was refused, or bytes were no frame");
    page.item("2", "", "The command can't be meant");
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
