// The word that somebody meant.
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace ano {

/// The candidate that `word` is most likely a slip of: few edits away (capitals do not count), else one that
/// contains it, or that it begins with.
/// Empty when none is near.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// " (did you mean 'baud'?)", or nothing.
std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates);

}    // namespace ano
