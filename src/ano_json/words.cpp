#include <ano/wire.hpp>
#include <ano_json/text.hpp>
#include <ano_json/words.hpp>

#include <algorithm>
#include <limits>

namespace ano {

std::string_view word_of(const Field& field, std::uint64_t value, ValueType7 seven) noexcept {
    if (field.role == Role::value_types && value == 7) return name_of(*command_value_type(7, seven));
    return field.meaning(value);
}

std::optional<std::uint32_t> value_called(const Field& field, std::string_view word, ValueType7 seven) noexcept {
    for (const Meaning& m : field.meanings)
        if (is_same_word(word_of(field, m.value, seven), word)) return m.value;
    return std::nullopt;
}

std::vector<std::string_view> words_for(const Field& field, ValueType7 seven) {
    std::vector<std::string_view> words;
    for (const Meaning& m : field.meanings) {
        const std::string_view word = word_of(field, m.value, seven);
        if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
    }
    return words;
}

bool is_same_word(std::string_view a, std::string_view b) noexcept {
    const auto folded = [](char c) {
        if (c == '_' || c == '-') return ' ';
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return folded(x) == folded(y); });
}

std::string carried(const Field& field) {
    std::string text{name_of(field.type)};
    if (!field.scale.is_one()) {
        const auto [min, max] = limits_of(field);
        text += ", " + number_text(min) + " to " + number_text(max);
    } else if (is_integer(field.type)) {
        text += with_type(field.type, []<class T>(T) {
            return ", " + std::to_string(std::numeric_limits<T>::min()) + " to " + std::to_string(std::numeric_limits<T>::max());
        });
    }
    if (!field.unit.empty()) text.append(" ").append(field.unit);
    return text;
}

}    // namespace ano
