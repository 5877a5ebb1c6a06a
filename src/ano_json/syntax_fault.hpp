// What is wrong in text that is no JSON.
#pragma once
#include <exception>
#include <string>
#include <string_view>

namespace ano {

/// "line 3, column 5: syntax error …; expected ']' (is a comma missing before it?)": what the library says of `text`, and the
/// slip that mostly makes it, where it can be told. `error` is what parsing `text` by nlohmann::json threw.
std::string syntax_fault(std::string_view text, const std::exception& error);

}    // namespace ano
