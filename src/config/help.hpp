// The texts of --help about links and the configuration file, generated from the tables of keys and kinds.
#pragma once
#include <config/link_kind.hpp>

#include <optional>
#include <string>

namespace anogate {

/// The description of a key, followed by its default `usual`, unless the help text already contains a default.
std::string help_of(const KeyFacts& key, const std::optional<std::string>& usual);

/// The kinds of links and the common options, on one screen of a terminal. `default_file`: the configuration used without a LINK.
std::string short_help(LinkKinds kinds, const std::string& default_file);
std::string links_and_keys_help(LinkKinds kinds);

}    // namespace anogate
