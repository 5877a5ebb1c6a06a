// A comment on the values of a field, in one line.
#pragma once
#include <ano/schema.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// "°; clockwise from the nose"; with `meanings` followed by "0: locked; 1: unlocked".
inline std::string comment_of(const ano::Field& f, bool meanings) {
    std::string text;
    const auto add = [&](std::string_view part) {
        if (part.empty()) return;
        if (!text.empty()) text += "; ";
        text += part;
    };
    add(f.unit);
    add(f.label);
    add(f.note);
    if (!meanings) return text;
    for (const ano::Meaning& m : f.meanings) add(std::to_string(m.value) + ": " + std::string{m.text});
    return text;
}

}    // namespace anogate
