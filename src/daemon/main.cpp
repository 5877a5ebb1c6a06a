// anogated: parses its command line and says what it would run.
#include <daemon/command_line.hpp>
#include <daemon/config.hpp>

#include <cstdio>

int main(int argc, char** argv) {
    using namespace anogate;
    const auto parsed = parse_command_line(argc, argv);
    if (const Exit* exit = std::get_if<Exit>(&parsed)) {
        std::fputs(exit->text.c_str(), exit->code == 0 ? stdout : stderr);
        return exit->code;
    }
    const CommandLine& line = std::get<CommandLine>(parsed);
    if (line.check && !line.print_config) return 0;
    std::fputs(print_config(line.settings).c_str(), stdout);
    return 0;
}
