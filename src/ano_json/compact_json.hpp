// JSON on one line, for programs. For display and for answers: json_text(), which escapes control characters.
#pragma once
#include <string>

namespace ano {

/// Without a line end. Bytes that are not UTF-8 become U+FFFD, so a text never causes an exception.
template <class Json>
std::string compact_json(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}    // namespace ano
