// Converts between numbers and their words.
#pragma once
#include <ano/schema.hpp>
#include <ano/values.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ano {

/// The word for `value` of `field`: "airborne"; empty: it has none.
std::string_view word_of(const Field& field, std::uint64_t value, ValueType7 seven) noexcept;

/// The value of `word` in `field`; the first one if several have the same word. Case is ignored, and '_' and '-' mean a space:
/// "restore_defaults".
std::optional<std::uint32_t> value_called(const Field& field, std::string_view word, ValueType7 seven) noexcept;

/// All words of `field`, each once, in the order of the table.
std::vector<std::string_view> words_for(const Field& field, ValueType7 seven);

/// Whether value_called() treats the two words as equal.
bool is_same_word(std::string_view a, std::string_view b) noexcept;

/// The range of the wire type of `field`: "i16, -327.68 to 327.67 °".
std::string carried(const Field& field);

}    // namespace ano
