// Prints lines for people; on a terminal, long lines are broken between words.
#pragma once
#include "anoctl.hpp"

#include <string>
#include <string_view>

namespace anoctl {

/// Prints to standard output.
void print(Streams& streams, std::string_view text);
/// Prints to standard error, with the prefix "anoctl: ".
void print_note(Streams& streams, std::string_view text);
/// Prints a question to standard error, without a line end.
void ask(Streams& streams, std::string_view question);
/// Reads the answer, without its line end.
std::string answer(const Streams& streams);
/// Asks the question. Returns whether the answer is yes.
bool agrees(Streams& streams, std::string_view question);

}    // namespace anoctl
