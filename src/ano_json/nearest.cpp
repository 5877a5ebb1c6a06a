#include <ano_json/nearest.hpp>

#include <algorithm>
#include <vector>

namespace ano {
namespace {

constexpr std::size_t longest_word = 64;    // nobody mistypes longer ones; keeps hostile input cheap

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// Letters added, left out, changed, or two swapped.
std::size_t edits(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before, above(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const bool same = lower(a[i - 1]) == lower(b[j - 1]);
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (same ? 0 : 1)});
            const bool swapped =
                i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
            if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
        }
        before = above;
        above = row;
    }
    return above[b.size()];
}

}    // namespace

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
    if (word.empty() || word.size() > longest_word) return {};
    std::string_view best;
    std::size_t fewest = 1 + word.size() / 4;
    for (const std::string_view candidate : candidates) {
        if (candidate.size() > longest_word) continue;
        const std::size_t count = edits(word, candidate);
        if (count > fewest || (count == fewest && !best.empty()) || count >= candidate.size()) continue;
        best = candidate;
        fewest = count;
    }
    if (!best.empty() || word.size() < 3) return best;
    const auto contains = [word](std::string_view c) { return c.find(word) != std::string_view::npos; };
    const auto found = std::find_if(candidates.begin(), candidates.end(), contains);
    return found != candidates.end() ? *found : best;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates) {
    const std::string_view meant = nearest(word, candidates);
    return meant.empty() ? std::string{} : " (did you mean '" + std::string{meant} + "'?)";
}

}    // namespace ano
