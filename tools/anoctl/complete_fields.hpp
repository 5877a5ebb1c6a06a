// The completions after the name of a message: FIELD=VALUE.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace anoctl {

/// The completions for the last of `words`, which begin with the subcommand; names of messages when none is given before it.
std::vector<std::string> field_words(std::span<const char* const> words);

}    // namespace anoctl
