// Where the log goes and what it looks like.
#pragma once
#include <gateway/settings.hpp>

namespace anogate {

/// Standard error, or a rotated file; with times unless the journal adds its own.
void start_log(const LogSettings& settings);

}  // namespace anogate
