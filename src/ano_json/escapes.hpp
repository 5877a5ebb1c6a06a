// Escapes characters that control a terminal, a log or a page, or reorder its text. Texts of devices may contain them.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace ano {

/// `text` with \uXXXX in place of each character detected by control_size(): ASCII controls and C1, marks of writing direction,
/// and characters without width. `text` is UTF-8.
std::string with_escapes(std::string_view text);
/// The same for JSON as text, in which ASCII controls are already escaped. The meaning does not change.
std::string with_json_escapes(std::string json);
/// `json` on one line, without a line end. Bytes that are not UTF-8 become U+FFFD.
std::string json_text(const nlohmann::ordered_json& json);

}    // namespace ano
