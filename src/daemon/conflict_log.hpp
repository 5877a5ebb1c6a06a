// That two devices may have one id, or one device two ways: for people.
#pragma once
#include <string>

namespace anogate {

struct Conflict;
class Gateway;

/// "0xDC is heard on fc and radio: …", with what to do about it.
std::string conflict_text(const Gateway& gateway, const Conflict& conflict);

}    // namespace anogate
