#include <http/client_network.hpp>
#include <http/places.hpp>
#include <http/request.hpp>

#include <algorithm>
#include <functional>
#include <map>

namespace anogate::http {
namespace {

constexpr std::size_t kept_for_control = 8;    // one place in so many

using Visitors = std::span<const Visitor>;

template <class Among>
std::optional<std::size_t> longest(Visitors visitors, Among among) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < visitors.size(); ++i)
        if (among(visitors[i]) && (!found || visitors[i].since < visitors[*found].since)) found = i;
    return found;
}

/// Who of them gives way first of those whose request is not here in full.
template <class Among>
std::optional<std::size_t> easiest(Visitors visitors, Among among) {
    const auto all = [&](Asking asking) { return [&among, asking](const Visitor& v) { return among(v) && v.asking == asking; }; };
    const auto nothing = std::count_if(visitors.begin(), visitors.end(), all(Asking::nothing));
    const auto half = std::count_if(visitors.begin(), visitors.end(), all(Asking::half));
    return longest(visitors, all(half > nothing ? Asking::half : nothing > 0 ? Asking::nothing : Asking::unheard));
}

using Held = std::map<std::uint64_t, std::size_t>;    // places of each

auto most_of(const Held& held) {
    return std::max_element(held.begin(), held.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
}

/// Who has to give, and what.
struct Giver {
    std::uint64_t who = 0;
    bool whole = false;    // requests too
};

/// `held` are the places of each, also of `newcomer`, who may have none. Nothing: there are more of them than places.
std::optional<Giver> giver_among(const Held& held, std::uint64_t newcomer) {
    std::size_t places = 0;
    for (const auto& [who, has] : held) places += has;
    const std::size_t share = std::max<std::size_t>(places / held.size(), 1);
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

Held held_by_clients(Visitors visitors) {
    Held held;
    for (const Visitor& visitor : visitors)
        if (is_of_network(visitor)) ++held[visitor.party.client];
    return held;
}

auto of_client(std::uint64_t client) {
    return [client](const Visitor& v) { return is_of_network(v) && v.party.client == client; };
}

/// One of the network's places, for a client of it.
std::optional<std::size_t> for_client(Visitors visitors, std::uint64_t newcomer) {
    Held held = held_by_clients(visitors);
    held.try_emplace(newcomer);
    const auto giver = giver_among(held, newcomer);
    return giver ? given_by(visitors, of_client(giver->who), giver->whole) : easiest(visitors, is_of_network);
}

/// One of the network's places, for a user of this machine.
std::optional<std::size_t> for_user(Visitors visitors) {
    if (const auto easy = easiest(visitors, is_of_network)) return easy;
    return longest(visitors, of_client(most_of(held_by_clients(visitors))->first));
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
    const auto look = std::count_if(visitors.begin(), visitors.end(), [](const Visitor& v) {
        return v.asking == Asking::whole && v.may && *v.may != Access::control;
    });
    return static_cast<std::size_t>(look) <= places - places / kept_for_control;
}

}    // namespace anogate::http
