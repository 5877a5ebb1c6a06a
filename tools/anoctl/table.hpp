// Columns for people.
#pragma once
#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Two spaces stand between columns; one without anything below its heading is left out.
class Table {
public:
    using Line = std::vector<std::string>;

    /// `heading` with as many cells as every row. A column whose heading begins with a space holds numbers: it is right-aligned.
    explicit Table(Line heading) : heading_{std::move(heading)} {}
    void row(Line cells) { lines_.push_back(std::move(cells)); }
    /// A line of its own below the last row.
    void note(std::string text) { lines_.push_back({std::move(text)}); }
    bool empty() const noexcept { return lines_.empty(); }
    void write(std::ostream& out, std::string_view indent = {}) const;

private:
    Line heading_;
    std::vector<Line> lines_;
};

/// How many cells of a terminal `text` takes: Chinese characters take two.
std::size_t cells_of(std::string_view text) noexcept;

/// Without control characters, which a terminal would obey: each becomes '?'.
std::string without_controls(std::string_view text);

/// "0.3 s", "12 s", "5 min", "3 h 12 min", "2 d 3 h"
std::string time_text(double seconds);

}    // namespace anoctl
