// Text without capitals.
#pragma once
#include <string>
#include <string_view>

namespace ano {

/// A to Z as small letters, all else as it is: it may be of any encoding.
inline std::string lower_case(std::string_view text) {
    std::string lower{text};
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return lower;
}

}    // namespace ano
