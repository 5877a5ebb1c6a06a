// The texts of --help about links and the configuration file, made from the tables of keys and kinds.
#pragma once
#include <config/link_kind.hpp>

#include <optional>
#include <string>

namespace anogate {

/// What a key does, followed by its default `usual`, unless the help text names a default itself.
std::string help_of(const KeyFacts& key, const std::optional<std::string>& usual);

/// What fits on one screen of a terminal: the kinds of links and the usual options. `default_file`: the configuration without a LINK.
std::string short_help(LinkKinds kinds, const std::string& default_file);
std::string links_and_keys_help(LinkKinds kinds);

}    // namespace anogate
