// Prints lines for people; on a terminal they are broken between words.
#pragma once
#include "anoctl.hpp"

#include <string>
#include <string_view>

namespace anoctl {

/// On standard output.
void say(Streams& streams, std::string_view text);
/// On standard error, after "anoctl: ".
void tell(Streams& streams, std::string_view text);
/// A question on standard error, without a line end.
void ask(Streams& streams, std::string_view question);
/// The line that answers it, without its end.
std::string answer(const Streams& streams);
/// Asks, and says whether the answer is yes.
bool agrees(Streams& streams, std::string_view question);

}    // namespace anoctl
