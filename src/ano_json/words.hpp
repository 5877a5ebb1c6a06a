// Converts between numbers and the words that stand for them.
#pragma once
#include <ano/schema.hpp>
#include <ano/values.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ano {

/// The word for `value` of `field`: "airborne"; empty when it has none.
std::string_view word_of(const Field& field, std::uint64_t value, ValueType7 seven) noexcept;

/// The value that `word` stands for in `field`, the first where several share it. Upper and lower case are the same, and '_' and
/// '-' stand for a space: "restore_defaults".
std::optional<std::uint32_t> value_called(const Field& field, std::string_view word, ValueType7 seven) noexcept;

/// All words of `field`, each once, in the order of the table.
std::vector<std::string_view> words_of(const Field& field, ValueType7 seven);

/// Whether value_called() takes the two words for the same.
bool is_same_word(std::string_view a, std::string_view b) noexcept;

/// What the wire type of `field` can carry: "i16, -327.68 to 327.67 °".
std::string carried(const Field& field);

}    // namespace ano
