#include <http/target.hpp>

#include <algorithm>
#include <charconv>
#include <utility>

namespace anogate::http {

Target split(std::string_view target) noexcept {
    for (const std::string_view scheme : {"http://", "https://"})
        if (target.starts_with(scheme)) {
            const auto path = target.find_first_of("/?", scheme.size());
            target = path == std::string_view::npos ? "/" : target.substr(path);
        }
    target = target.substr(0, target.find('#'));
    const auto mark = target.find('?');
    if (mark == std::string_view::npos) return {target, {}};
    return {target.substr(0, mark), target.substr(mark + 1)};
}

std::optional<std::string> percent_decoded(std::string_view text, bool plus_is_space) {
    std::string decoded;
    decoded.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += plus_is_space && text[i] == '+' ? ' ' : text[i];
            continue;
        }
        const std::string_view digits = text.substr(i + 1, 2);
        unsigned value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
        if (digits.size() != 2 || error != std::errc{} || end != digits.data() + 2 || value == 0) return std::nullopt;
        decoded += static_cast<char>(value);
        i += 2;
    }
    return decoded;
}

std::optional<std::vector<Field>> parse_query(std::string_view query) {
    std::vector<Field> fields;
    while (!query.empty()) {
        const std::string_view word = query.substr(0, query.find('&'));
        query.remove_prefix(std::min(word.size() + 1, query.size()));
        if (word.empty()) continue;
        const auto equals = std::min(word.find('='), word.size());
        auto name = percent_decoded(word.substr(0, equals), true);
        auto value = percent_decoded(word.substr(std::min(equals + 1, word.size())), true);
        if (!name || !value) return std::nullopt;
        fields.push_back({std::move(*name), std::move(*value)});
    }
    return fields;
}

std::string without_query_value(std::string_view target, std::string_view name) {
    const auto mark = std::min(target.find('?'), target.size());
    std::string kept{target.substr(0, mark)};
    char between = '?';
    for (std::string_view rest = target.substr(std::min(mark + 1, target.size())); !rest.empty();) {
        const std::string_view word = rest.substr(0, rest.find('&'));
        rest.remove_prefix(std::min(word.size() + 1, rest.size()));
        if (percent_decoded(word.substr(0, word.find('=')), true) == name) continue;
        kept.append(1, std::exchange(between, '&')).append(word);
    }
    return kept;
}

}    // namespace anogate::http
