#include "say.hpp"

#include <anoctl/text/table.hpp>

#include <unistd.h>

#include <ostream>
#include <string>

namespace anoctl {
namespace {

constexpr std::size_t hanging_indent = 4;    // indent of all lines but the first

std::size_t width_of(bool is_terminal, const Streams& streams) { return is_terminal ? streams.width : 0; }

}    // namespace

void print(Streams& streams, std::string_view text) {
    streams.out << wrapped(text, width_of(streams.terminal, streams), hanging_indent) << '\n';
}

void print_note(Streams& streams, std::string_view text) {
    streams.out.flush();
    streams.err << wrapped("anoctl: " + std::string{text}, width_of(streams.err_is_terminal, streams), hanging_indent)
                << std::endl;
}

void ask(Streams& streams, std::string_view question) {
    streams.out.flush();
    streams.err << wrapped(std::string{question} + " [y/N]", width_of(streams.err_is_terminal, streams), hanging_indent) << ' '
                << std::flush;
}

std::string answer(const Streams& streams) {
    std::string line;
    char c = 0;
    while (::read(streams.in, &c, 1) == 1 && c != '\n') line += c;
    return line;
}

bool agrees(Streams& streams, std::string_view question) {
    ask(streams, question);
    const std::string word = answer(streams);
    return word == "y" || word == "Y" || word == "yes";
}

}    // namespace anoctl
