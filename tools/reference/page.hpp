// A manual page, written in mdoc(7).
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace reference {

class Page {
public:
    /// `summary` is one clause without a full stop.
    Page(std::string_view name, int section, std::string_view summary);

    void section(std::string_view title);
    void subsection(std::string_view title);
    /// Adds text; no part of it is read as an mdoc command.
    void text(std::string_view words);
    /// Adds a paragraph break between two texts.
    void paragraph();
    /// Adds lines that are not reformatted.
    void literal(std::string_view lines);

    /// Begins a list of terms with explanations.
    void begin_list();
    /// Adds a term: `name` is typed literally, `value` is a placeholder; either may be empty.
    void item(std::string_view name, std::string_view value, std::string_view words);
    void end_list();

    /// Adds a synopsis line with options and operands in square brackets.
    void synopsis(std::string_view program, std::string_view arguments);
    void see_also(const std::vector<std::string>& pages);    // "anoctl 1"

    const std::string& str() const noexcept { return text_; }

private:
    void macro(std::string_view line);

    std::string text_;
    bool began_ = false;    // the section or item already has content
};

}    // namespace reference
