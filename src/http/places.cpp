#include <http/client_network.hpp>
#include <http/places.hpp>
#include <http/request.hpp>

#include <algorithm>
#include <functional>
#include <map>

namespace anogate::http {
namespace {

constexpr std::size_t one_is_kept_in = 8;    // of the places, for clients that may control

using Visitors = std::span<const Visitor>;

template <class Among>
std::optional<std::size_t> longest(Visitors visitors, Among among) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < visitors.size(); ++i)
        if (among(visitors[i]) && (!found || visitors[i].since < visitors[*found].since)) found = i;
    return found;
}

/// The first to give way among those without a complete request.
template <class Among>
std::optional<std::size_t> easiest(Visitors visitors, Among among) {
    const auto all = [&](Asking asking) { return [&among, asking](const Visitor& v) { return among(v) && v.asking == asking; }; };
    const auto nothing = std::count_if(visitors.begin(), visitors.end(), all(Asking::nothing));
    const auto half = std::count_if(visitors.begin(), visitors.end(), all(Asking::half));
    return longest(visitors, all(half > nothing ? Asking::half : nothing > 0 ? Asking::nothing : Asking::unheard));
}

using Held = std::map<std::uint64_t, std::size_t>;    // party or client → its number of places

auto most_of(const Held& held) {
    return std::max_element(held.begin(), held.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
}

/// The share of each in all places that are held.
std::size_t share_of(const Held& held) {
    std::size_t places = 0;
    for (const auto& [who, has] : held) places += has;
    return std::max<std::size_t>(places / held.size(), 1);
}

/// The party that must give up a place.
struct Giver {
    std::uint64_t who = 0;
    bool whole = false;    // complete requests may be given up too
};

/// `held` includes `newcomer`, perhaps with 0 places. std::nullopt: nobody is above the share.
std::optional<Giver> giver_among(const Held& held, std::uint64_t newcomer) {
    const std::size_t share = share_of(held);
    if (held.at(newcomer) >= share) return Giver{newcomer, false};
    const auto most = most_of(held);
    return most->second > share ? std::optional{Giver{most->first, true}} : std::nullopt;
}

template <class Among>
std::optional<std::size_t> given_by(Visitors visitors, Among among, bool whole) {
    const auto easy = easiest(visitors, among);
    return easy || !whole ? easy : longest(visitors, among);
}

bool is_of_network(const Visitor& visitor) { return visitor.party.user == unknown_user; }

bool is_whole(const Visitor& visitor) { return visitor.asking == Asking::whole; }
bool controls(const Visitor& visitor) { return visitor.may == Access::control; }

template <class Among>
Held held_by_clients(Visitors visitors, Among among) {
    Held held;
    for (const Visitor& visitor : visitors)
        if (is_of_network(visitor) && among(visitor)) ++held[visitor.party.client];
    return held;
}

/// Of the network's clients with most visitors that fulfil `among`: the first to give way, in the order of gives_way().
template <class Among>
std::optional<std::size_t> of_crowd(Visitors visitors, Among among, bool whole) {
    const Held held = held_by_clients(visitors, among);
    if (held.empty()) return {};
    const auto of_those = [&, most = most_of(held)->second](const Visitor& v) {
        return is_of_network(v) && among(v) && held.at(v.party.client) == most;
    };
    return given_by(visitors, of_those, whole);
}

/// A client of the network without a complete request; clients that may control come last.
std::optional<std::size_t> easy_client(Visitors visitors) {
    const auto easy = of_crowd(
        visitors, [](const Visitor& v) { return !is_whole(v) && !controls(v); }, false);
    return easy ? easy
                : of_crowd(
                      visitors, [](const Visitor& v) { return !is_whole(v); }, false);
}

bool looks(const Visitor& visitor) { return is_whole(visitor) && !controls(visitor); }

/// One of the network's places for another of its clients. A complete request of a client that controls is never given up.
std::optional<std::size_t> for_client(Visitors visitors, std::uint64_t newcomer) {
    if (const auto easy = easy_client(visitors)) return easy;
    const auto is_his = [newcomer](const Visitor& v) { return is_of_network(v) && v.party.client == newcomer; };
    const auto may_control = [&](const Visitor& v) { return is_his(v) && controls(v); };
    if (std::any_of(visitors.begin(), visitors.end(), may_control)) return of_crowd(visitors, looks, true);
    Held held = held_by_clients(visitors, is_of_network);
    held.try_emplace(newcomer);
    const Held looking = held_by_clients(visitors, looks);
    const std::size_t share = share_of(held);
    const bool takes = !looking.empty() && held.at(newcomer) < share && most_of(looking)->second > share;
    return takes ? of_crowd(visitors, looks, true) : std::nullopt;
}

/// One of the network's places for a user of this machine.
std::optional<std::size_t> for_user(Visitors visitors) {
    if (const auto easy = easy_client(visitors)) return easy;
    const auto looker = of_crowd(visitors, looks, true);
    return looker ? looker : of_crowd(visitors, is_of_network, true);
}

}    // namespace

Party party_of(std::uint32_t user, const Door& door) {
    if (!door.is_network) return {user, 0};
    return {unknown_user, std::hash<std::string>{}(client_network(door.peer))};
}

std::optional<std::size_t> gives_way(Visitors visitors, const Party& party, bool first) {
    Held held{{party.user, 0}};
    for (const Visitor& visitor : visitors) ++held[visitor.party.user];
    const auto giver = giver_among(held, party.user);
    if (giver && giver->who == unknown_user)
        return party.user == unknown_user ? for_client(visitors, party.client) : for_user(visitors);
    if (giver)
        return given_by(
            visitors, [who = giver->who](const Visitor& v) { return v.party.user == who; }, giver->whole);
    const auto anybody = [](const Visitor&) { return true; };
    return given_by(visitors, anybody, first);
}

bool has_place(Visitors visitors, std::size_t places, Access access) {
    if (access == Access::control) return true;
    const std::size_t kept = places / one_is_kept_in;
    const auto look = std::count_if(visitors.begin(), visitors.end(), looks);
    const auto whole = std::count_if(visitors.begin(), visitors.end(), is_whole);
    return static_cast<std::size_t>(look) <= places - kept && static_cast<std::size_t>(whole) <= places - (kept > 0 ? 1 : 0);
}

std::optional<std::size_t> leaves_room(Visitors visitors, std::size_t places) {
    const auto whole = std::count_if(visitors.begin(), visitors.end(), is_whole);
    if (places < one_is_kept_in || static_cast<std::size_t>(whole) < places) return {};
    return of_crowd(visitors, looks, true);
}

}    // namespace anogate::http
