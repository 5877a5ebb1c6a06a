#include <ano_json/json_writer.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace ano {
namespace {

// Characters that need no escape in JSON.
constexpr std::array<bool, 256> plain = [] {
    std::array<bool, 256> table{};
    for (std::size_t c = ' '; c < 0x7F; ++c) table[c] = c != '"' && c != '\\';
    return table;
}();

}    // namespace

void JsonWriter::text(std::string_view text) {
    begin_value();
    const bool is_plain = std::all_of(text.begin(), text.end(), [](char c) { return plain[static_cast<unsigned char>(c)]; });
    if (is_plain) out_.append(1, '"').append(text).append(1, '"');
    else out_ += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// Not std::to_chars, which writes 2.5e7 as 2.5e+07.
void JsonWriter::number(double number) {
    if (!std::isfinite(number)) return null();
    std::array<char, 64> room;
    const char* const end = nlohmann::detail::to_chars(room.data(), room.data() + room.size(), number);
    literal({room.data(), static_cast<std::size_t>(end - room.data())});
}

void JsonWriter::number(std::int64_t number) {
    std::array<char, 24> room;
    const char* const end = std::to_chars(room.data(), room.data() + room.size(), number).ptr;
    literal({room.data(), static_cast<std::size_t>(end - room.data())});
}

void JsonWriter::number(std::uint64_t number) {
    std::array<char, 24> room;
    const char* const end = std::to_chars(room.data(), room.data() + room.size(), number).ptr;
    literal({room.data(), static_cast<std::size_t>(end - room.data())});
}

}    // namespace ano
