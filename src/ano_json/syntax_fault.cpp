#include <ano_json/syntax_fault.hpp>

#include <nlohmann/json.hpp>

namespace ano {
namespace {

constexpr std::string_view space = " \t\r\n";

bool has(std::string_view message, std::string_view part) {
    return message.find(part) != message.npos;
}

/// What stands before the closing bracket that ends `text`.
bool ends_with_comma_and_bracket(std::string_view text) {
    text.remove_suffix(1);
    const std::size_t last = text.find_last_not_of(space);
    return last != text.npos && text[last] == ',';
}

/// `read` is the text up to and with what was not expected.
std::string_view slip(std::string_view read, std::string_view message) {
    if (has(message, "0x'") || has(message, "0X'")) return "a number in hex stands in double quotes: \"0xDC\"";
    if (has(message, "#'")) return "a comment begins with //";
    if (has(message, "unexpected end of input")) return "is a closing bracket or quote missing?";
    if (has(message, "invalid literal")) return "names and texts stand in double quotes: \"fc\"";
    const bool closing = !read.empty() && (read.back() == ']' || read.back() == '}');
    if (closing && ends_with_comma_and_bracket(read)) return "is there a comma too many before it?";
    const bool between = message.ends_with("expected ']'") || message.ends_with("expected '}'");
    if (between && (has(message, "literal;") || has(message, "unexpected '{'") || has(message, "unexpected '['")))
        return "is a comma missing before it?";
    return {};
}

}    // namespace

std::string syntax_fault(std::string_view text, const std::exception& error) {
    std::string message = error.what();
    if (const std::size_t line = message.find("line "); line != message.npos) message.erase(0, line);
    const auto* parse_error = dynamic_cast<const nlohmann::json::parse_error*>(&error);
    if (parse_error == nullptr) return message;
    const std::string_view hint = slip(text.substr(0, parse_error->byte), message);
    if (!hint.empty()) message.append(" (").append(hint).append(")");
    return message;
}

}    // namespace ano
