// Checks the files for TCP access to the control interface and for encrypted links.
#pragma once
#include <config/config.hpp>

namespace anogate {

/// Adds a warning for TLS files that can't be used and for a token file that can't be read or created, with the same texts that
/// the gateway logs. Changes no file. With `is_for_service`, files that only the service may read are not checked.
void warn_of_listener(Draft& draft, bool is_for_service);

}    // namespace anogate
