// Checks the files that the TCP access to the control interface and encrypted links need.
#pragma once
#include <config/config.hpp>

namespace anogate {

/// Adds a warning for TLS files that can't be used and for a token file that can't be read or made, in the same words that the gateway
/// would log. Changes no file. With `is_for_service`, files that only the service may read are not checked.
void warn_of_door(Draft& draft, bool is_for_service);

}    // namespace anogate
