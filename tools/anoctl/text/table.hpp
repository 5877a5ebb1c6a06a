// Prints tables for people.
#pragma once
#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Columns are separated by two spaces. A column with a heading but no content is omitted.
class Table {
public:
    using Line = std::vector<std::string>;

    /// `heading` must have as many cells as every row. A column whose heading begins with a space contains numbers and is
    /// right-aligned.
    explicit Table(Line heading) : heading_{std::move(heading)} {}
    void row(Line cells) { lines_.push_back(std::move(cells)); }
    /// Adds a line of text below the last row.
    void note(std::string text) { lines_.push_back({std::move(text)}); }
    bool empty() const noexcept { return lines_.empty(); }
    /// Prints at most `width` cells per line, if possible (0: no limit). Columns that don't fit are placed below the others; the
    /// last column is broken between words.
    void write(std::ostream& out, std::string_view indent = {}, std::size_t width = 0) const;

private:
    struct Column;
    std::vector<Column> columns(std::size_t indent, std::size_t width) const;

    Line heading_;
    std::vector<Line> lines_;
};

/// Number of terminal cells of `text`: Chinese characters have two.
std::size_t cells_of(std::string_view text) noexcept;

/// The beginning of `text` that fits in `cells`; characters are never split.
std::string in_cells(std::string_view text, std::size_t cells);

/// `text` with its colours; if it exceeds `cells`, its beginning and "…". 0: no limit.
std::string cut_line(std::string_view text, std::size_t cells);

/// Wraps `text` to lines of at most `width` cells, broken between words or Chinese characters. The lines after the first begin
/// with `indent` spaces; on the first one, `begin` cells are already used. Words longer than a line are not broken. `width` 0:
/// unchanged.
std::string wrapped(std::string_view text, std::size_t width, std::size_t indent = 0, std::size_t begin = 0);

/// Replaces control characters, which a terminal would execute, by '?'.
std::string without_controls(std::string_view text);

/// "1 waypoint", "3 waypoints"
std::string plural(std::size_t number, const std::string& word);

/// "0.3 s", "12 s", rounded to the nearest; from two minutes on rounded down: "5 min", "3 h 12 min", "2 d 3 h"
std::string time_text(double seconds);

}    // namespace anoctl
