#include <http/listeners/accept.hpp>
#include <http/without_spaces.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace anogate::http {
namespace {

/// Removes the text before the next `separator` from the front of `rest` and returns it.
std::string_view next_token(std::string_view& rest, char separator) {
    const auto end = std::min(rest.find(separator), rest.size());
    const std::string_view word = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return without_spaces(word);
}

bool same_word(std::string_view one, std::string_view other) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    return std::equal(one.begin(), one.end(), other.begin(), other.end(), [&](char a, char b) { return lower(a) == lower(b); });
}

/// 750 for "0.75"; 0 if the text is not a number.
unsigned thousandths(std::string_view text) {
    double value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value > 0 && value <= 1 ? static_cast<unsigned>(std::lround(value * 1000)) : 0;
}

}    // namespace

std::optional<unsigned> quality(std::string_view accept, std::string_view type, std::string_view version) {
    std::optional<unsigned> best;
    while (!accept.empty()) {
        std::string_view entry = next_token(accept, ',');
        if (!same_word(next_token(entry, ';'), type)) continue;
        unsigned wanted = 1000;
        bool is_meant = true;
        while (!entry.empty()) {
            std::string_view parameter = next_token(entry, ';');
            const std::string_view name = next_token(parameter, '=');
            if (same_word(name, "q")) wanted = thousandths(parameter);
            if (same_word(name, "version") && !version.empty()) is_meant = parameter == version;
        }
        if (is_meant) best = std::max(best.value_or(0), wanted);
    }
    return best;
}

}    // namespace anogate::http
