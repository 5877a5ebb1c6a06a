// The error message for text that is not JSON.
#pragma once
#include <exception>
#include <string>
#include <string_view>

namespace ano {

/// "line 3, column 5: syntax error …; expected ']' (is a comma missing before it?)": the message of the library for `text`, and
/// the likely mistake, if it can be recognised. `error` is the exception of nlohmann::json for `text`.
std::string syntax_fault(std::string_view text, const std::exception& error);

}    // namespace ano
