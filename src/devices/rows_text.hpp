// Builds a JSON object with a long list a few rows at a time, so that the loop is not blocked.
#pragma once
#include <devices/works/work.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <string_view>

namespace anogate {

/// {"device": {…}, "parameters": [row, …], "incomplete": "…"}, exact (json_line.hpp) and without spaces.
class RowsText {
public:
    /// Rows added in one turn of the loop.
    static constexpr std::size_t rows_a_turn = 64;
    /// Limit of the text; no real device needs more.
    static constexpr std::size_t max_bytes = std::size_t{32} << 20;

    /// `head` must not be empty.
    RowsText(const nlohmann::ordered_json& head, std::string_view list);
    void add(const nlohmann::ordered_json& row);
    std::size_t size() const noexcept { return text_.size(); }
    /// Appends `tail` after the list and returns `end` with the complete text as its result.
    WorkEnd ended(WorkEnd end, const nlohmann::ordered_json& tail);

private:
    std::string text_;
    bool is_empty_ = true;
};

/// The end of a work whose list is larger than max_bytes.
WorkEnd too_many_bytes(std::uint8_t address);

}    // namespace anogate
