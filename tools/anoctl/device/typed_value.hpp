// A value as somebody typed it, and the type that a device wants.
#pragma once
#include <string>

namespace anoctl {

/// Why `word` is no value of the type that is called so, as a clause: "'300' is out of range, i8 is -128 to 127". Empty: it is one, or
/// the type is not known.
std::string misfit_of(const std::string& word, const std::string& type_name);

}    // namespace anoctl
