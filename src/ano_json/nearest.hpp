// Suggestions for mistyped words.
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace ano {

/// The candidate that was most likely meant by `word`: few edits away (upper and lower case are the same), otherwise one that
/// contains `word`, or that `word` begins with. Empty when none is near.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// " (did you mean 'baud'?)", or "".
std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates);

/// " (did you mean '0xDC'?)" for a number in hex that lacks its 0x: DC, xDC, DCh, $DC, with that many digits. Empty for anything
/// else, also for what can be read as a decimal number.
std::string did_you_mean_hex(std::string_view word, std::size_t max_digits = 2);

/// 0xDC for such a word; empty for any other.
std::string as_hex(std::string_view word, std::size_t max_digits = 2);

}    // namespace ano
