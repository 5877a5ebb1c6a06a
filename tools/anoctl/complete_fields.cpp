#include "complete_fields.hpp"

#include <ano/messages.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/words.hpp>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

namespace anoctl {
namespace {

using Words = std::span<const char* const>;

/// The message of the first word that names one and is not the value of an option.
std::optional<std::uint8_t> message_in(Words words) {
    for (std::size_t i = 1; i < words.size(); ++i) {
        const std::string_view word = words[i], before = words[i - 1];
        if (word.starts_with('-') || before == "--from" || before == "--to" || before == "=") continue;
        const auto id = ano::message_id(std::string{word});
        if (const auto* found = std::get_if<std::uint8_t>(&id)) return *found;
    }
    return std::nullopt;
}

// Spaces in the value names of the table are written as '_'.
void add_values(std::uint8_t id, std::string_view name, const std::string& before, std::vector<std::string>& all) {
    for (const ano::Message& row : ano::layouts_of(id)) {
        const ano::Field* const field = row.field(name);
        if (field == nullptr) continue;
        for (const std::string_view word : ano::words_for(*field, ano::ValueType7::f32)) {
            std::string value = before + std::string{word};
            std::replace(value.begin(), value.end(), ' ', '_');
            if (std::find(all.begin(), all.end(), value) == all.end()) all.push_back(std::move(value));
        }
    }
}

bool is_given(Words words, std::string_view field) {
    return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
        return word == field || (word.starts_with(field) && word.substr(field.size()).starts_with('='));
    });
}

void add_fields(std::uint8_t id, Words words, std::vector<std::string>& all) {
    for (const ano::Message& row : ano::layouts_of(id))
        for (const ano::Field& field : row.fields()) {
            std::string word = std::string{field.name} + "=";
            const bool is_new = std::find(all.begin(), all.end(), word) == all.end();
            if (is_new && !is_given(words.first(words.size() - 1), field.name)) all.push_back(std::move(word));
        }
}

std::vector<std::string> all_messages() {
    std::vector<std::string> all;
    for (const ano::Message& row : ano::messages) all.emplace_back(row.name);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
}

}    // namespace

std::vector<std::string> field_words(Words words) {
    std::vector<std::string> all;
    if (words.empty()) return all;
    const auto id = message_in(words.first(words.size() - 1));
    if (!id) return all_messages();
    const auto from_end = [&](std::size_t n) { return n <= words.size() ? std::string_view{words[words.size() - n]} : ""; };
    const std::string_view last = from_end(1);
    const std::size_t equals = last.find('=');
    if (last == "=") add_values(*id, from_end(2), "", all);
    else if (from_end(2) == "=") add_values(*id, from_end(3), "", all);
    else if (equals != last.npos) add_values(*id, last.substr(0, equals), std::string{last.substr(0, equals + 1)}, all);
    else add_fields(*id, words, all);
    return all;
}

}    // namespace anoctl
