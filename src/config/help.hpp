// What --help says of links and of the configuration file, made from the tables.
#pragma once
#include <config/link_kind.hpp>

#include <optional>
#include <string>

namespace anogate {

/// What a key does, with its `usual` value as text behind it, unless the help speaks of a default itself.
std::string help_of(const KeyFacts& key, const std::optional<std::string>& usual);

std::string links_and_keys_help(LinkKinds kinds);

}    // namespace anogate
