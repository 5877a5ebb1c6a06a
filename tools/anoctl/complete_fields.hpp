// Completions after the name of a message: FIELD=VALUE.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace anoctl {

/// The completions for the last of `words`, which begin with the subcommand; if no message is named before it, the names of
/// messages.
std::vector<std::string> field_words(std::span<const char* const> words);

}    // namespace anoctl
