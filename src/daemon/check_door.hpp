// The files that the network door of the control interface needs.
#pragma once
#include <config/config.hpp>

namespace anogate {

/// Adds a warning, in the words that the door will have, for TLS files that it can't use and for a file of tokens that it can't
/// read or make. Changes none of them. Where they are for the service, what only the service may read is not judged.
void warn_of_door(Draft& draft, bool is_for_service);

}    // namespace anogate
