#include <http/range.hpp>
#include <http/without_spaces.hpp>

#include <algorithm>
#include <charconv>
#include <optional>

namespace anogate::http {
namespace {

constexpr std::string_view unit = "bytes=";

// A number that does not fit into 64 bits counts as beyond the end.
std::optional<std::uint64_t> number_of(std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (text.empty() || end != text.data() + text.size()) return std::nullopt;
    return error == std::errc::result_out_of_range ? UINT64_MAX : number;
}

}    // namespace

Range wanted_range(std::string_view header, std::uint64_t size) {
    const Range whole{Range::Kind::whole, 0, size}, outside{Range::Kind::outside, 0, 0};
    if (!header.starts_with(unit)) return whole;
    const std::string_view words = without_spaces(header.substr(unit.size()));
    const std::size_t dash = words.find('-');
    if (dash == words.npos || words.find(',') != words.npos) return whole;
    const std::string_view from = words.substr(0, dash), to = words.substr(dash + 1);
    const auto first = number_of(from), last = number_of(to);
    if ((!from.empty() && !first) || (!to.empty() && !last) || (from.empty() && to.empty())) return whole;
    if (from.empty()) {
        const std::uint64_t count = std::min(*last, size);
        return count == 0 ? outside : Range{Range::Kind::part, size - count, count};
    }
    if (last && *last < *first) return whole;
    if (*first >= size) return outside;
    const std::uint64_t end = last && *last < size ? *last + 1 : size;
    return {Range::Kind::part, *first, end - *first};
}

}    // namespace anogate::http
