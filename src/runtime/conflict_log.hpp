// The message for a conflict: two devices may have the same id, or one device is heard on two links.
#pragma once
#include <gateway/hints.hpp>
#include <gateway/router.hpp>

#include <string>

namespace anogate {

class Gateway;

SharedSource meaning_of(const Gateway& gateway, const Conflict& conflict);
/// "0xDC is heard on fc and radio: …", with what to do about it.
std::string conflict_text(const Gateway& gateway, const Conflict& conflict);
/// The line for an address that is at home on another link now.
std::string move_text(const Gateway& gateway, const Router::Moved& moved);

}    // namespace anogate
