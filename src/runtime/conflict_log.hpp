// The message for a conflict: two devices may have the same id, or frames of one device are received on two links.
#pragma once
#include <gateway/hints.hpp>
#include <gateway/router.hpp>

#include <string>

namespace anogate {

class Gateway;

SharedSource meaning_of(const Gateway& gateway, const Conflict& conflict);
/// "0xDC is heard on fc and radio: …", with the action to take.
std::string conflict_text(const Gateway& gateway, const Conflict& conflict);
/// The line for an address whose route moved to another link.
std::string move_text(const Gateway& gateway, const Router::Moved& moved);

}    // namespace anogate
