// Suggestions for mistyped words.
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace ano {

/// The candidate that `word` most likely means: one with few edits (upper and lower case are the same), otherwise one that
/// contains `word`, or with which `word` begins. Empty: none is similar.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// " (did you mean 'baud'?)", or "".
std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates);

/// " (did you mean '0xDC'?)" for a number in hex without 0x: DC, xDC, DCh, $DC, with at most `max_digits` digits. Empty for any
/// other text, also for valid decimal numbers.
std::string did_you_mean_hex(std::string_view word, std::size_t max_digits = 2);

/// 0xDC for such a word; empty for any other.
std::string as_hex(std::string_view word, std::size_t max_digits = 2);

}    // namespace ano
