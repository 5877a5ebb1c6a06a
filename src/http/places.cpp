#include <http/client/client_network.hpp>
#include <http/places.hpp>
#include <http/request.hpp>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace anogate::http {
namespace {

constexpr std::size_t one_is_kept_in = 8;    // one place in this many is reserved for clients that may control

using ClientConnections = std::span<const ClientConnection>;

template <class Among>
std::size_t number_of(ClientConnections connections, Among among) {
    return static_cast<std::size_t>(std::count_if(connections.begin(), connections.end(), among));
}

template <class Among>
std::size_t number_of(ClientConnections connections, const ClientId& client_id, Among among) {
    return number_of(connections, [&](const ClientConnection& v) { return v.client_id == client_id && among(v); });
}

template <class Among>
std::optional<std::size_t> longest(ClientConnections connections, Among among) {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < connections.size(); ++i)
        if (among(connections[i]) && (!found || connections[i].since < connections[*found].since)) found = i;
    return found;
}

/// The party with most visitors of `among`, if they are more than `more_than`.
template <class Among>
std::optional<ClientId> crowd(ClientConnections connections, std::size_t more_than, Among among) {
    std::vector<std::pair<ClientId, std::size_t>> parties;    // in a flood from one address, one: counted in linear time
    for (const ClientConnection& connection : connections) {
        if (!among(connection)) continue;
        const auto is_same = [&](const auto& one) { return one.first == connection.client_id; };
        const auto at = std::find_if(parties.begin(), parties.end(), is_same);
        if (at == parties.end()) parties.emplace_back(connection.client_id, 1);
        else ++at->second;
    }
    std::optional<ClientId> found;
    for (const auto& [client_id, has] : parties)
        if (has > more_than) found = client_id, more_than = has;
    return found;
}

/// The oldest visitor of `among` of the party with most of those, if they are more than `more_than`.
template <class Among>
std::optional<std::size_t> oldest_of_crowd(ClientConnections connections, std::size_t more_than, Among among) {
    const auto whose = crowd(connections, more_than, among);
    if (!whose) return {};
    return longest(connections, [&](const ClientConnection& v) { return v.client_id == *whose && among(v); });
}

bool is_whole(const ClientConnection& connection) { return connection.asking == Asking::whole; }
bool controls(const ClientConnection& connection) { return connection.may == Access::control; }
bool looks(const ClientConnection& connection) { return is_whole(connection) && !controls(connection); }

/// The one among `easy` whose connection is closed first.
template <class Easy>
std::optional<std::size_t> easiest(ClientConnections connections, Easy easy) {
    const auto whose = crowd(connections, 0, easy);
    if (!whose) return {};
    const auto all = [&](Asking asking) {
        return [&, asking](const ClientConnection& v) { return v.client_id == *whose && easy(v) && v.asking == asking; };
    };
    Asking sort = Asking::nothing;
    for (const Asking other : {Asking::half, Asking::unheard})
        if (number_of(connections, all(other)) > number_of(connections, all(sort))) sort = other;
    return longest(connections, all(sort));
}

}    // namespace

ClientId client_id_of(std::uint32_t user, const ConnectionInfo& connection_info) {
    if (!connection_info.is_network) return {user, 0};
    return {unknown_user, std::hash<std::string>{}(client_network(connection_info.peer))};
}

std::optional<std::size_t> next_evicted(ClientConnections connections, ano::TimePoint connected_before) {
    const auto is_easy = [connected_before](const ClientConnection& v) {
        return !is_whole(v) && (v.asking != Asking::unheard || v.since < connected_before);
    };
    if (const auto easy = easiest(connections, [&](const ClientConnection& v) { return is_easy(v) && !controls(v); }))
        return easy;
    if (const auto easy = easiest(connections, [&](const ClientConnection& v) { return is_easy(v) && v.by_address; }))
        return easy;
    if (const auto easy = easiest(connections, is_easy)) return easy;
    if (const auto viewer_to_close = oldest_of_crowd(connections, 0, looks)) return viewer_to_close;
    return oldest_of_crowd(connections, 0, [](const ClientConnection& v) { return is_whole(v) && v.lasts; });
}

PlaceFor request_place(ClientConnections connections, std::size_t places, const ClientId& client_id, Access access) {
    const std::size_t for_all = places - places / one_is_kept_in;
    if (access == Access::control || number_of(connections, looks) <= for_all) return {true, {}};
    const auto leaves = oldest_of_crowd(connections, number_of(connections, client_id, looks), looks);
    return {leaves.has_value(), leaves};
}

PlaceFor stream_place(ClientConnections connections, std::size_t streams, const ClientId& client_id, Access access) {
    constexpr std::size_t one_in = 4;    // one place in this many is reserved for clients that may control
    const bool may_control = access == Access::control;
    const auto views = [](const ClientConnection& v) { return v.streams && !controls(v); };
    const auto is_equal = [&](const ClientConnection& v) { return v.streams && controls(v) == may_control; };
    const bool is_full = number_of(connections, [](const ClientConnection& v) { return v.streams; }) >= streams;
    if (!is_full && (may_control || number_of(connections, views) < streams - streams / one_in)) return {true, {}};
    if (may_control)
        if (const auto viewer = oldest_of_crowd(connections, 0, views)) return {true, viewer};
    const auto leaves = oldest_of_crowd(connections, number_of(connections, client_id, is_equal) + 1, is_equal);
    return {leaves.has_value(), leaves};
}

std::optional<std::size_t> oldest_stream(ClientConnections connections) {
    return longest(connections, [](const ClientConnection& v) { return v.streams; });
}

}    // namespace anogate::http
