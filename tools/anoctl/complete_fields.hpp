// What can stand behind the name of a message: FIELD=VALUE.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace anoctl {

/// What a shell offers for the last of `words`, which begin with the subcommand: the messages when none is named before it.
std::vector<std::string> field_words(std::span<const char* const> words);

}    // namespace anoctl
