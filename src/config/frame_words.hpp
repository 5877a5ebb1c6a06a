// The words for frames in rules: ids, messages and traffic classes; and hardware ids for source and destination.
#pragma once
#include <gateway/filter.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// An id (0xF0, 240), a range of ids (0x01-0x0F), the name of a message (firmware) or of a traffic class (telemetry).
/// std::nullopt: none of these.
std::optional<std::vector<ByteRange>> parse_frames(std::string_view text);
/// All words that parse_frames() accepts, for suggestions.
std::vector<std::string_view> frame_words();

/// " (did you mean '0xDC-0xDE'?)" for addresses or ids in hex without 0x, or "".
std::string meant_addresses(std::string_view text);
/// The same, or a suggestion of a word of parse_frames() that is similar to `text`.
std::string meant_frames(std::string_view text);

/// In hex: 0x01 or 0xF0-0xF1.
std::string range_text(ByteRange range);

/// The rate limit of one id or message, or the error.
struct LimitText {
    std::optional<LimitRule> rule;
    std::string error;
};
LimitText parse_limit(std::string_view name, std::string_view rate);
/// Inserts it in the order of the ids and returns "", or returns the error: "0x01 already has a limit".
std::string add_limit(const LimitRule& rule, std::vector<LimitRule>& limits);

}    // namespace anogate
