#include <ano_json/lower_case.hpp>
#include <ano_json/syntax_fault.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <string>

namespace ano {
namespace {

constexpr std::string_view space = " \t\r\n";

bool has(std::string_view message, std::string_view part) { return message.find(part) != message.npos; }

/// Whether a comma precedes the closing bracket that ends `text`.
bool ends_with_comma_and_bracket(std::string_view text) {
    text.remove_suffix(1);
    const std::size_t last = text.find_last_not_of(space);
    return last != text.npos && text[last] == ',';
}

/// The word of letters at `at`.
std::string word_at(std::string_view text, std::size_t at) {
    const auto is_letter = [&](std::size_t i) { return std::isalpha(static_cast<unsigned char>(text[i])) != 0; };
    std::size_t begin = at, end = at;
    while (begin > 0 && is_letter(begin - 1)) --begin;
    while (end < text.size() && is_letter(end)) ++end;
    return lower_case(text.substr(begin, end - begin));
}

/// Booleans of other languages, and of our own command line.
bool is_truth_value(std::string_view word) {
    constexpr std::string_view words[]{"true", "false", "yes", "no", "on", "off"};
    return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

/// A hint about the likely mistake. The parser stopped at `byte`, the last byte that it read.
std::string_view slip(std::string_view text, std::size_t byte, std::string_view message) {
    const std::string_view read = text.substr(0, byte);
    if (text.find_first_not_of(space) == text.npos) return "it is empty";
    if (has(message, "invalid literal") && !read.empty() && is_truth_value(word_at(text, read.size() - 1)))
        return "write true or false";
    if (has(message, "0x'") || has(message, "0X'")) return "put hex numbers in double quotes: \"0xDC\"";
    if (has(message, "#'")) return "a comment begins with //";
    if (has(message, "unexpected end of input")) return "is a closing bracket or quote missing?";
    if (has(message, "invalid literal")) return "put names and texts in double quotes: \"fc\"";
    const bool closing = !read.empty() && (read.back() == ']' || read.back() == '}');
    if (closing && ends_with_comma_and_bracket(read)) return "is there an extra comma before it?";
    const bool between = message.ends_with("expected ']'") || message.ends_with("expected '}'");
    if (between && (has(message, "literal;") || has(message, "unexpected '{'") || has(message, "unexpected '['")))
        return "is a comma missing before it?";
    return {};
}

/// The error for a number that is too large for a double: the message of the parser contains the number, but not its place.
std::string too_large(std::string_view text, std::string_view message) {
    const std::size_t quote = message.find('\'');
    const std::string_view number = quote == message.npos ? "" : message.substr(quote + 1, message.rfind('\'') - quote - 1);
    const auto until = text.begin() + static_cast<std::ptrdiff_t>(std::min(text.find(number), text.size()));
    const auto line = std::count(text.begin(), until, '\n') + 1;
    return "line " + std::to_string(line) + ": the number " + std::string{number} + " is too large";
}

}    // namespace

std::string syntax_fault(std::string_view text, const std::exception& error) {
    constexpr int number_overflow = 406;
    std::string message = error.what();
    if (const auto* range = dynamic_cast<const nlohmann::json::out_of_range*>(&error); range && range->id == number_overflow)
        return too_large(text, message);
    if (const std::size_t line = message.find("line "); line != message.npos) message.erase(0, line);
    const auto* parse_error = dynamic_cast<const nlohmann::json::parse_error*>(&error);
    if (parse_error == nullptr) return message;
    const std::string_view hint = slip(text, parse_error->byte, message);
    if (!hint.empty()) message.append(" (").append(hint).append(")");
    return message;
}

}    // namespace ano
