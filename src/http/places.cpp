#include <http/client/client_network.hpp>
#include <http/places.hpp>
#include <http/request.hpp>

#include <algorithm>
#include <functional>

namespace anogate::http {
namespace {

constexpr std::size_t one_is_kept_in = 8;    // one place in this many is reserved for clients that may control

using Visitors = std::span<const Visitor>;

template <class Among>
std::size_t number_of(Visitors visitors, Among among) {
    return static_cast<std::size_t>(std::count_if(visitors.begin(), visitors.end(), among));
}

template <class Among>
std::size_t number_of(Visitors visitors, const Party& party, Among among) {
    return number_of(visitors, [&](const Visitor& v) { return v.party == party && among(v); });
}

template <class Among>
std::optional<std::size_t> longest(Visitors visitors, Among among) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < visitors.size(); ++i)
        if (among(visitors[i]) && (!found || visitors[i].since < visitors[*found].since)) found = i;
    return found;
}

/// The party with most visitors of `among`, if they are more than `more_than`.
template <class Among>
std::optional<Party> crowd(Visitors visitors, std::size_t more_than, Among among) {
    std::optional<Party> found;
    for (const Visitor& visitor : visitors) {
        if (!among(visitor)) continue;
        const std::size_t has = number_of(visitors, visitor.party, among);
        if (has > more_than) found = visitor.party, more_than = has;
    }
    return found;
}

/// The oldest visitor of `among` of the party with most of those, if they are more than `more_than`.
template <class Among>
std::optional<std::size_t> oldest_of_crowd(Visitors visitors, std::size_t more_than, Among among) {
    const auto whose = crowd(visitors, more_than, among);
    if (!whose) return {};
    return longest(visitors, [&](const Visitor& v) { return v.party == *whose && among(v); });
}

bool is_whole(const Visitor& visitor) { return visitor.asking == Asking::whole; }
bool controls(const Visitor& visitor) { return visitor.may == Access::control; }
bool looks(const Visitor& visitor) { return is_whole(visitor) && !controls(visitor); }

/// The one among `easy` whose connection is closed first.
template <class Easy>
std::optional<std::size_t> easiest(Visitors visitors, Easy easy) {
    const auto whose = crowd(visitors, 0, easy);
    if (!whose) return {};
    const auto all = [&](Asking asking) {
        return [&, asking](const Visitor& v) { return v.party == *whose && easy(v) && v.asking == asking; };
    };
    Asking sort = Asking::nothing;
    for (const Asking other : {Asking::half, Asking::unheard})
        if (number_of(visitors, all(other)) > number_of(visitors, all(sort))) sort = other;
    return longest(visitors, all(sort));
}

}    // namespace

Party party_of(std::uint32_t user, const Door& door) {
    if (!door.is_network) return {user, 0};
    return {unknown_user, std::hash<std::string>{}(client_network(door.peer))};
}

std::optional<std::size_t> gives_way(Visitors visitors, ano::TimePoint connected_before) {
    const auto is_easy = [connected_before](const Visitor& v) {
        return !is_whole(v) && (v.asking != Asking::unheard || v.since < connected_before);
    };
    if (const auto easy = easiest(visitors, [&](const Visitor& v) { return is_easy(v) && !controls(v); })) return easy;
    if (const auto easy = easiest(visitors, [&](const Visitor& v) { return is_easy(v) && v.by_address; })) return easy;
    if (const auto easy = easiest(visitors, is_easy)) return easy;
    if (const auto looker = oldest_of_crowd(visitors, 0, looks)) return looker;
    return oldest_of_crowd(visitors, 0, [](const Visitor& v) { return is_whole(v) && v.lasts; });
}

PlaceFor request_place(Visitors visitors, std::size_t places, const Party& party, Access access) {
    const std::size_t for_all = places - places / one_is_kept_in;
    if (access == Access::control || number_of(visitors, looks) <= for_all) return {true, {}};
    const auto leaves = oldest_of_crowd(visitors, number_of(visitors, party, looks), looks);
    return {leaves.has_value(), leaves};
}

PlaceFor stream_place(Visitors visitors, std::size_t streams, const Party& party, Access access) {
    constexpr std::size_t one_in = 4;    // one place in this many is reserved for clients that may control
    const bool may_control = access == Access::control;
    const auto views = [](const Visitor& v) { return v.streams && !controls(v); };
    const auto is_equal = [&](const Visitor& v) { return v.streams && controls(v) == may_control; };
    const bool is_full = number_of(visitors, [](const Visitor& v) { return v.streams; }) >= streams;
    if (!is_full && (may_control || number_of(visitors, views) < streams - streams / one_in)) return {true, {}};
    if (may_control)
        if (const auto viewer = oldest_of_crowd(visitors, 0, views)) return {true, viewer};
    const auto leaves = oldest_of_crowd(visitors, number_of(visitors, party, is_equal) + 1, is_equal);
    return {leaves.has_value(), leaves};
}

std::optional<std::size_t> oldest_stream(Visitors visitors) {
    return longest(visitors, [](const Visitor& v) { return v.streams; });
}

}    // namespace anogate::http
