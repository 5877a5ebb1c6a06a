// Characters that control or reorder what a terminal, a log or a page shows: a text of a device must not bring them there as they are.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace ano {

/// `text` with \uXXXX in place of each character that control_size() knows: ASCII controls and C1, marks of writing direction, and
/// characters without width. `text` is UTF-8.
std::string with_escapes(std::string_view text);
/// The same for JSON as text, in which ASCII controls are escaped already: it means the same.
std::string with_json_escapes(std::string json);
/// `json` in one line, without its end. Bytes that are not UTF-8 become U+FFFD.
std::string json_text(const nlohmann::ordered_json& json);

}    // namespace ano
