#include "anoctl.hpp"

#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <string_view>

int main(int argc, char** argv) {
    std::ios::sync_with_stdio(false);
    const char* term = std::getenv("TERM");
    const bool terminal = isatty(STDOUT_FILENO) == 1;
    const bool color =
        terminal && std::getenv("NO_COLOR") == nullptr && term != nullptr && std::string_view{term} != "dumb";
    anoctl::Streams streams{STDIN_FILENO, std::cout, std::cerr, terminal, color, isatty(STDIN_FILENO) == 1};
    return anoctl::run(argc, argv, streams);
}
