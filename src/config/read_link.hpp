// What both ways of writing a link share.
#pragma once
#include <gateway/settings.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// Settings of `kind`, a row of link kinds, with `queue` 0: not given yet.
LinkSettings new_link(std::string_view kind);

/// "unknown kind 'seriel' (did you mean 'serial'?); a kind is serial, ..."
std::string unknown_kind(std::string_view kind);

}    // namespace anogate
