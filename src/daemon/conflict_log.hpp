// The message for a conflict: two devices may have the same id, or one device is heard on two links.
#pragma once
#include <string>

namespace anogate {

struct Conflict;
class Gateway;

/// "0xDC is heard on fc and radio: …", with what to do about it.
std::string conflict_text(const Gateway& gateway, const Conflict& conflict);

}    // namespace anogate
