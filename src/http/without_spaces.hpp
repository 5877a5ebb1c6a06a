#pragma once
#include <string_view>

namespace anogate::http {

/// `text` without blanks and tabs at both ends.
inline std::string_view without_spaces(std::string_view text) noexcept {
    const auto begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

}    // namespace anogate::http
