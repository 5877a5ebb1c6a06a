// Lines for people: on a terminal broken between words.
#pragma once
#include "anoctl.hpp"

#include <string_view>

namespace anoctl {

/// On standard output.
void say(Streams& streams, std::string_view text);
/// On standard error, behind "anoctl: ".
void tell(Streams& streams, std::string_view text);
/// A question on standard error; the cursor stays behind it.
void ask(Streams& streams, std::string_view question);

}    // namespace anoctl
