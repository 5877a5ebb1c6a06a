#include <daemon/control_places.hpp>

#include <algorithm>
#include <map>

namespace anogate {
namespace {

template <class Among>
std::optional<std::size_t> longest(std::span<const Visitor> visitors, Among among) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < visitors.size(); ++i)
        if (among(visitors[i]) && (!found || visitors[i].since < visitors[*found].since)) found = i;
    return found;
}

}  // namespace

std::optional<std::size_t> gives_way(std::span<const Visitor> visitors, std::uint32_t user, bool first) {
    std::map<std::uint32_t, std::size_t> held{{user, 0}};
    for (const Visitor& visitor : visitors) ++held[visitor.user];
    const std::size_t share = std::max<std::size_t>(visitors.size() / held.size(), 1);
    const auto idle_of = [&](std::uint32_t whose) {
        return longest(visitors, [whose](const Visitor& v) { return v.user == whose && !v.busy; });
    };
    if (held[user] >= share) return idle_of(user);
    const auto most = std::max_element(held.begin(), held.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    const std::uint32_t greedy = most->first;
    if (most->second > share) {
        if (const auto idle = idle_of(greedy)) return idle;
        return longest(visitors, [greedy](const Visitor& v) { return v.user == greedy; });
    }
    if (const auto idle = longest(visitors, [](const Visitor& v) { return !v.busy; })) return idle;
    return first ? longest(visitors, [](const Visitor&) { return true; }) : std::nullopt;
}

}  // namespace anogate
