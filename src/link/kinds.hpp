// The list of all kinds of links. A new kind is one source file and one row in kinds.cpp.
#pragma once
#include <config/link_kind.hpp>

namespace anogate {

LinkKinds link_kinds() noexcept;
/// nullptr if no kind has this name.
inline const LinkKind* find_link_kind(std::string_view name) noexcept { return find_link_kind(link_kinds(), name); }

}    // namespace anogate
