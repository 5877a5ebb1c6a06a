// Shared by the two formats of a link: LINK text and JSON object.
#pragma once
#include <config/link_kind.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// "unknown kind 'seriel' (did you mean 'serial'?); a kind is serial, ..."
std::string unknown_kind(LinkKinds kinds, std::string_view kind);

}    // namespace anogate
