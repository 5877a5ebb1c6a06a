// Faults for errno.
#pragma once
#include <ano/fault.hpp>

#include <string>

namespace anogate {

/// With the text of error_text(place, error).
ano::Fault error_fault(const std::string& place, int error);

}    // namespace anogate
