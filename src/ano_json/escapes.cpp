#include <ano_json/compact_json.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <utility>

namespace ano {
namespace {

void append_unit(std::string& out, std::uint32_t unit) {
    std::array<char, 8> room{};
    std::snprintf(room.data(), room.size(), "\\u%04x", unit);
    out += room.data();
}

void append_escape(std::string& out, std::uint32_t code) {
    constexpr std::uint32_t beyond = 0x10000;
    if (code < beyond) return append_unit(out, code);
    append_unit(out, 0xD800 + ((code - beyond) >> 10));
    append_unit(out, 0xDC00 + ((code - beyond) & 0x3FF));
}

std::string escaped(std::string_view text, bool also_ascii) {
    std::string out;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t size = !also_ascii && static_cast<std::uint8_t>(text[at]) < 0x20 ? 0 : control_size(text, at);
        if (size > 0) append_escape(out, code_point(text.substr(at, size)));
        else out += text[at];
        at += std::max(size, std::size_t{1});
    }
    return out;
}

bool has_any(std::string_view text, bool also_ascii) noexcept {
    for (std::size_t at = 0; at < text.size(); ++at)
        if ((also_ascii || static_cast<std::uint8_t>(text[at]) >= 0x20) && control_size(text, at) > 0) return true;
    return false;
}

}    // namespace

std::string with_escapes(std::string_view text) { return has_any(text, true) ? escaped(text, true) : std::string{text}; }

std::string with_json_escapes(std::string json) { return has_any(json, false) ? escaped(json, false) : std::move(json); }

std::string json_text(const nlohmann::ordered_json& json) { return with_json_escapes(compact_json(json)); }

}    // namespace ano
