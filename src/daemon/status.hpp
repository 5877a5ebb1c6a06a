// The state of a gateway as JSON (the shape is part of the interface: README, "Looking at it").
#pragma once
#include <string>

namespace anogate {

class Gateway;

/// GET /status, GET /links, GET /routes: one JSON text each.
std::string status_json(Gateway& gateway);
/// The same in a few lines for the log.
std::string status_text(Gateway& gateway);

}  // namespace anogate
