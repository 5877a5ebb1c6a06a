#include <anoctl/text/terminal.hpp>
#include "anoctl.hpp"

#include <unistd.h>

#include <cstdlib>
#include <iostream>

int main(int argc, char** argv) {
    std::ios::sync_with_stdio(false);
    const bool terminal = isatty(STDOUT_FILENO) == 1;
    const bool color = terminal && anoctl::use_color(std::getenv("NO_COLOR"), std::getenv("TERM"));
    anoctl::Streams streams{STDIN_FILENO,
                            std::cout,
                            std::cerr,
                            terminal,
                            color,
                            isatty(STDIN_FILENO) == 1,
                            isatty(STDERR_FILENO) == 1,
                            anoctl::Screen::size().width};
    return anoctl::run(argc, argv, streams);
}
