// Converts text to lower case.
#pragma once
#include <string>
#include <string_view>

namespace ano {

/// Changes only A to Z, so `text` may have any encoding.
inline std::string lower_case(std::string_view text) {
    std::string lower{text};
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return lower;
}

}    // namespace ano
