#include "page.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

namespace reference {
namespace {

// mdoc requires a date: that of the last change of the pages' form, not of their generated content.
constexpr char date[] = "November 22, 2026";

/// Escapes backslashes, and hyphens, which would otherwise be copied as other characters.
std::string escaped(std::string_view words) {
    std::string out;
    for (const char c : words) {
        if (c == '\\') out += "\\e";
        else if (c == '-') out += "\\-";
        else out += c;
    }
    return out;
}

/// Escapes a line whose beginning would be read as a command.
std::string format_line(std::string_view line) {
    const bool is_command = !line.empty() && (line.front() == '.' || line.front() == '\'');
    return (is_command ? "\\&" : "") + escaped(line) + "\n";
}

/// Breaks `words` into lines of at most 80 bytes, as mdoc requires.
std::string lines_of_text(std::string_view words) {
    constexpr std::size_t width = 78;    // \& may be added before it
    std::string all;
    while (escaped(words).size() > width) {
        std::size_t end = std::min(words.size(), width);
        while (end != 0 && (words[end - 1] != ' ' || escaped(words.substr(0, end)).size() > width)) --end;
        if (end == 0) end = std::min(words.find(' '), words.size() - 1) + 1;    // a word longer than a line
        all += format_line(words.substr(0, end - (words[end - 1] == ' ' ? 1 : 0)));
        words.remove_prefix(end);
    }
    return words.empty() ? all : all + format_line(words);
}

/// Quotes an argument of a macro.
std::string argument(std::string_view word) {
    std::string out = "\"\\&";
    for (const char c : escaped(word)) out += c == '"' ? std::string{"\"\""} : std::string{c};
    return out + "\"";
}

bool ends_sentence(std::string_view words, std::size_t at) {
    return words[at] == '.' && at + 2 < words.size() && words[at + 1] == ' ' &&
           std::isupper(static_cast<unsigned char>(words[at + 2])) != 0;
}

}    // namespace

Page::Page(std::string_view name, int section_number, std::string_view summary) {
    std::string title{name};
    for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    macro(std::string{"Dd "} + date);
    macro("Dt " + escaped(title) + " " + std::to_string(section_number));
    macro("Os anogate");
    macro("Sh NAME");
    macro("Nm " + escaped(name));
    macro("Nd " + escaped(summary));
}

void Page::macro(std::string_view line) { text_.append(".").append(line).append("\n"); }

void Page::section(std::string_view title) {
    macro("Sh " + escaped(title));
    began_ = false;
}

void Page::subsection(std::string_view title) {
    macro("Ss " + argument(title));
    began_ = false;
}

// mdoc requires each sentence on its own line.
void Page::text(std::string_view words) {
    for (std::size_t at = 0; at < words.size(); ++at) {
        if (!ends_sentence(words, at)) continue;
        text_ += lines_of_text(words.substr(0, at + 1));
        words.remove_prefix(at + 2);
        at = 0;
    }
    text_ += lines_of_text(words);
    began_ = true;
}

void Page::paragraph() {
    if (began_) macro("Pp");
}

void Page::literal(std::string_view lines) {
    macro("Bd -literal -offset indent");
    std::istringstream in{std::string{lines}};
    for (std::string line; std::getline(in, line);) text_ += format_line(line);
    macro("Ed");
    began_ = true;
}

void Page::begin_list() { macro("Bl -tag -width Ds"); }
void Page::end_list() {
    macro("El");
    began_ = true;
}

void Page::item(std::string_view name, std::string_view value, std::string_view words) {
    std::string line = "It";
    if (!name.empty()) line += " Cm " + argument(name);
    if (!value.empty()) line += " Ar " + argument(value);
    macro(line);
    began_ = false;
    text(words);
}

void Page::synopsis(std::string_view program, std::string_view arguments) {
    macro("Nm " + escaped(program));
    if (!arguments.empty()) macro("Ar " + argument(arguments));
    began_ = true;
}

void Page::see_also(const std::vector<std::string>& pages) {
    section("SEE ALSO");
    for (std::size_t i = 0; i < pages.size(); ++i) macro("Xr " + pages[i] + (i + 1 < pages.size() ? " ," : ""));
}

}    // namespace reference
