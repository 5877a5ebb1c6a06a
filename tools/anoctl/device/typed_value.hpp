// Checks a typed value against the type that a device requires.
#pragma once
#include <cstdint>
#include <string>

namespace anoctl {

/// A clause with the reason why `word` is not a value of the type `type_name`: "'300' is out of range, i8 is -128 to 127". Empty:
/// it is valid, or the type is not known. `mul`: the number in the frame is the value times this.
std::string misfit_of(const std::string& word, const std::string& type_name, std::int32_t mul = 1);

}    // namespace anoctl
