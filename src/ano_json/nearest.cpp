#include <ano_json/nearest.hpp>

#include <algorithm>
#include <vector>

namespace ano {
namespace {

constexpr std::size_t max_word = 64;    // longer words are not typed by hand; the limit keeps hostile input cheap
constexpr std::size_t min_part = 3;     // this number of letters is enough to identify a word

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

char as_it_is(char c) { return c; }

/// The number of edits: a letter added, removed or changed, or two swapped. `form` is applied to letters before they are
/// compared.
std::size_t edits(std::string_view a, std::string_view b, char (*form)(char) = lower) {
    std::vector<std::size_t> before, above(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const bool same = form(a[i - 1]) == form(b[j - 1]);
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (same ? 0 : 1)});
            const bool swapped = i > 1 && j > 1 && form(a[i - 1]) == form(b[j - 2]) && form(a[i - 2]) == form(b[j - 1]);
            if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
        }
        before = above;
        above = row;
    }
    return above[b.size()];
}

/// Decides between two candidates with the same number of edits. One that starts with `word` ("of": off, not on) precedes one
/// that does not; then the one with fewer edits when case counts ("fligth": flight, not FLIGHT); otherwise the first.
bool is_rather_meant(std::string_view candidate, std::string_view best, std::string_view word) {
    const bool begun = candidate.starts_with(word), best_is_begun = best.starts_with(word);
    return begun != best_is_begun ? begun : edits(word, candidate, as_it_is) < edits(word, best, as_it_is);
}

/// For example "timeout" in peer_timeout.
bool contains_word(std::string_view candidate, std::string_view word) { return candidate.find(word) != candidate.npos; }

/// For example "baud" at the beginning of baudrate.
bool begins_word(std::string_view candidate, std::string_view word) {
    return candidate.size() >= min_part && word.starts_with(candidate);
}

}    // namespace

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
    if (word.empty() || word.size() > max_word) return {};
    std::string_view best;
    std::size_t max_edits = 1 + word.size() / 4;
    for (const std::string_view candidate : candidates) {
        if (candidate.size() > max_word) continue;
        const std::size_t count = edits(word, candidate);
        if (count > max_edits || count * 2 > candidate.size()) continue;
        if (count == max_edits && !best.empty() && !is_rather_meant(candidate, best, word)) continue;
        best = candidate;
        max_edits = count;
    }
    if (!best.empty() || word.size() < min_part) return best;
    for (const auto part : {contains_word, begins_word})
        for (const std::string_view candidate : candidates)
            if (part(candidate, word)) return candidate;
    return {};
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates) {
    const std::string_view meant = nearest(word, candidates);
    return meant.empty() ? std::string{} : " (did you mean '" + std::string{meant} + "'?)";
}

std::string as_hex(std::string_view word, std::size_t max_digits) {
    constexpr std::string_view decimal = "0123456789", letters = "abcdefABCDEF";
    bool marked = false;
    for (const std::string_view mark : {"\\x", "x", "X", "$", "#"})
        if (!marked && word.starts_with(mark)) {
            word.remove_prefix(mark.size());
            marked = true;
        }
    if (!marked && !word.empty() && lower(word.back()) == 'h') {
        word.remove_suffix(1);
        marked = true;
    }
    if (word.empty() || word.size() > max_digits) return {};
    if (word.find_first_not_of(std::string{decimal}.append(letters)) != word.npos) return {};
    if (!marked && word.find_first_of(letters) == word.npos) return {};
    std::string text = "0x";
    for (const char c : word) text += c >= 'a' ? static_cast<char>(c - 'a' + 'A') : c;
    return text;
}

std::string did_you_mean_hex(std::string_view word, std::size_t max_digits) {
    const std::string meant = as_hex(word, max_digits);
    return meant.empty() ? std::string{} : " (did you mean '" + meant + "'?)";
}

}    // namespace ano
