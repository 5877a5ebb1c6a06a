#include <http/places.hpp>

#include <algorithm>
#include <map>

namespace anogate::http {
namespace {

template <class Among>
std::optional<std::size_t> longest(std::span<const Visitor> visitors, Among among) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < visitors.size(); ++i)
        if (among(visitors[i]) && (!found || visitors[i].since < visitors[*found].since)) found = i;
    return found;
}

/// Who of them gives way first of those whose request is not here in full.
template <class Among>
std::optional<std::size_t> easiest(std::span<const Visitor> visitors, Among among) {
    const auto all = [&](Asking asking) { return [&among, asking](const Visitor& v) { return among(v) && v.asking == asking; }; };
    const auto nothing = std::count_if(visitors.begin(), visitors.end(), all(Asking::nothing));
    const auto half = std::count_if(visitors.begin(), visitors.end(), all(Asking::half));
    return longest(visitors, all(half > nothing ? Asking::half : nothing > 0 ? Asking::nothing : Asking::unheard));
}

}    // namespace

std::optional<std::size_t> gives_way(std::span<const Visitor> visitors, std::uint32_t user, bool first) {
    std::map<std::uint32_t, std::size_t> held{{user, 0}};
    for (const Visitor& visitor : visitors) ++held[visitor.user];
    const std::size_t share = std::max<std::size_t>(visitors.size() / held.size(), 1);
    const auto anybody = [](const Visitor&) { return true; };
    if (held[user] >= share) return easiest(visitors, [user](const Visitor& v) { return v.user == user; });
    const auto most = std::max_element(held.begin(), held.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most->second > share) {
        const auto of_greedy = [greedy = most->first](const Visitor& v) { return v.user == greedy; };
        const auto easy = easiest(visitors, of_greedy);
        return easy ? easy : longest(visitors, of_greedy);
    }
    if (const auto easy = easiest(visitors, anybody)) return easy;
    return first ? longest(visitors, anybody) : std::nullopt;
}

}    // namespace anogate::http
