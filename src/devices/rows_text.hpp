// A JSON object with a long list, made a few rows at a time so that the loop goes on meanwhile.
#pragma once
#include <devices/work.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <string_view>

namespace anogate {

/// {"device": {…}, "parameters": [row, …], "incomplete": "…"}, exact (json_line.hpp) and without spaces.
class RowsText {
public:
    /// Rows of one turn of the loop.
    static constexpr std::size_t rows_a_turn = 64;
    /// A device that describes more bytes than this is no use to anybody.
    static constexpr std::size_t max_bytes = std::size_t{32} << 20;

    /// `head` has something in it.
    RowsText(const nlohmann::ordered_json& head, std::string_view list);
    void add(const nlohmann::ordered_json& row);
    std::size_t size() const noexcept { return text_.size(); }
    /// With what stands behind the list; `end` has the whole as its result.
    WorkEnd ended(WorkEnd end, const nlohmann::ordered_json& tail);

private:
    std::string text_;
    bool is_empty_ = true;
};

/// The end of a work whose list has become too large.
WorkEnd too_many_bytes(std::uint8_t address);

}    // namespace anogate
