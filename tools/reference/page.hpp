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
    /// A text; nothing in it is taken for a command of mdoc.
    void text(std::string_view words);
    /// A paragraph break between two texts.
    void paragraph();
    /// Lines that are not reformatted.
    void literal(std::string_view lines);

    /// A list of terms with explanations.
    void begin_list();
    /// `name` is typed literally, `value` is a placeholder; either may be empty.
    void item(std::string_view name, std::string_view value, std::string_view words);
    void end_list();

    /// A line with how the program is called: options and operands in square brackets.
    void synopsis(std::string_view program, std::string_view arguments);
    void see_also(const std::vector<std::string>& pages);    // "anoctl 1"

    const std::string& str() const noexcept { return text_; }

private:
    void macro(std::string_view line);

    std::string text_;
    bool began_ = false;    // this section or item has content already
};

}    // namespace reference
