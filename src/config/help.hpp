// What --help says of links and of the configuration file, made from the tables.
#pragma once
#include <config/link_kind.hpp>

#include <string>

namespace anogate {

std::string links_and_keys_help(LinkKinds kinds);

}    // namespace anogate
