#include <config/check_network.hpp>
#include <config/hosts_file.hpp>
#include <config/link_kind.hpp>
#include <gateway/tunnel/tunnel_policy.hpp>

#include <algorithm>
#include <charconv>
#include <optional>

namespace anogate {
namespace {

Reach reach_of(const LinkSettings& link) { return link.kind->reach ? link.kind->reach(link) : Reach::here; }

/// The first link with peers in the network whose tunnel frames the tunnel sends; empty: there is none.
std::string open_tunnel_link(const Settings& settings) {
    for (const LinkSettings& link : settings.links) {
        const std::vector<std::string>& carried = settings.tunnel->links;
        if (reach_of(link) != Reach::here && std::find(carried.begin(), carried.end(), link.name) != carried.end())
            return link.name;
    }
    return {};
}

void check_way(Draft& draft, const Network* listed) {
    if (!listed || draft.settings.tunnel->relay) return;
    const std::string link = open_tunnel_link(draft.settings);
    if (link.empty()) return;
    draft.errors.push_back({draft.tunnel.key("allow"), "'allow' lists " + listed->text() +
                                                           ", which is this computer, and 'links' includes " + in_quotes(link) +
                                                           ": its network peers could reach local programs through tunnel "
                                                           "frames; remove one of them, or set \"relay\": true to allow it"});
}

struct OwnPort {
    BoundPort port;
    std::string use;    // "'g' (LINK …) listens there"
};

std::vector<OwnPort> own_ports(const Draft& draft) {
    std::vector<OwnPort> ports;
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i)
        if (const auto bound = bound_port_of(draft.settings.links[i]))
            ports.push_back({*bound, in_quotes(draft.settings.links[i].name) + " (" + draft.links[i].where + ") listens there"});
    if (const auto& http = draft.settings.control.http) ports.push_back({{*http, {}, {}, true}, "its page is served there"});
    return ports;
}

// Without the hosts file, localhost is 127.0.0.1 for every resolver, and ::1 only for some.
std::vector<IpAddress> addresses_of(const HostSpec& peer, const HostAddresses& names) {
    if (peer.host.empty()) return {peer.address};
    std::string name = in_lower_case(peer.host);
    if (name.ends_with('.')) name.pop_back();
    const auto found = names.find(name);
    if (found != names.end()) return found->second;
    return name == "localhost" ? std::vector{IpAddress::v4(127, 0, 0, 1)} : std::vector<IpAddress>{};
}

// A UDP link uses one address of a name: one of the family of 'bind', IPv4 by default, if it has any. TCP tries all of them.
std::vector<IpAddress> addresses_used_by(const LinkSettings& link, const PeerPort& to, const HostAddresses& names) {
    std::vector<IpAddress> all = addresses_of(to.peer, names);
    if (to.is_tcp) return all;
    const auto bound = bound_port_of(link);
    const auto is_other = [v6 = bound && bound->local.address.v6](const IpAddress& one) { return one.v6 != v6; };
    if (!std::all_of(all.begin(), all.end(), is_other)) all.erase(std::remove_if(all.begin(), all.end(), is_other), all.end());
    return all;
}

bool is_address_of(const std::vector<Network>& own, const IpAddress& address) {
    return std::any_of(own.begin(), own.end(), [&](const Network& network) { return network.address == address; });
}

// Packets of this computer to its own addresses arrive at lo. A socket at 0.0.0.0 receives IPv4 only, one at [::] both.
bool receives(const BoundPort& bound, const HostSpec& peer, const IpAddress& to, const std::vector<Network>& own) {
    const EndpointSpec& local = bound.local;
    if (to.is_multicast()) return false;    // other hosts receive it too
    if (to == local.address) return peer.interface == local.interface;
    return local.address.is_any() && (local.address.v6 || !to.v6) && (bound.interface.empty() || bound.interface == "lo") &&
           (to.is_loopback() || is_address_of(own, to));
}

/// Whether the link certainly leads there: also if a name has further addresses, unless they may belong to another computer.
bool leads_to(const LinkSettings& link, const PeerPort& to, const BoundPort& bound, const HostAddresses& names,
              const std::vector<Network>& own) {
    if (to.is_tcp != bound.is_tcp || to.peer.port == 0 || to.peer.port != bound.local.port) return false;
    const std::vector<IpAddress> used = addresses_used_by(link, to, names);
    const auto is_received = [&](const IpAddress& one) { return receives(bound, to.peer, one, own); };
    return std::any_of(used.begin(), used.end(), is_received) &&
           std::all_of(used.begin(), used.end(), [&](const IpAddress& one) { return one.is_loopback() || is_received(one); });
}

std::size_t max_channels_of(const LinkSettings& link) {
    const Key<LinkSettings>* const key = find_key(link.kind->keys, "max_peers");
    std::size_t peers = 1;
    if (const std::string text = key == nullptr ? "" : key->text_in(link).value_or(""); !text.empty())
        std::from_chars(text.data(), text.data() + text.size(), peers);
    return peers;
}

/// `leads(link, to, port)`: whether this is an error.
template <typename Leads>
void add_own_peers(Draft& draft, Leads leads) {
    const std::vector<OwnPort> ports = own_ports(draft);
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i)
        if (const auto to = peer_port_of(draft.settings.links[i]))
            for (const OwnPort& one : ports)
                if (leads(draft.settings.links[i], *to, one.port))
                    draft.errors.push_back(
                        {draft.links[i].key(to->key), in_quotes(to->peer.text()) + " is this gateway itself: " + one.use});
}

}    // namespace

void check_channels(Draft& draft) {
    std::size_t sum = 0, most = 1;
    std::optional<std::size_t> largest;
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i) {
        const std::size_t channels = max_channels_of(draft.settings.links[i]);
        sum += channels;
        if (channels <= most) continue;
        most = channels;
        largest = i;
    }
    if (sum <= max_channels || !largest) return;
    draft.warnings.push_back({draft.links[*largest].key("max_peers"),
                              "note: the links may have " + std::to_string(sum) + " channels together, and the gateway has " +
                                  std::to_string(max_channels) +
                                  ": when all are in use, silent peers are replaced and new ones may be refused; lower "
                                  "'max_peers'"});
}

void check_peers(Draft& draft) {
    add_own_peers(draft, [](const LinkSettings& link, const PeerPort& to, const BoundPort& bound) {
        return leads_to(link, to, bound, {}, {});
    });
}

// The errors that need neither `names` nor `own` were added before.
void check_peers(Draft& draft, const HostAddresses& names, const std::vector<Network>& own) {
    add_own_peers(draft, [&](const LinkSettings& link, const PeerPort& to, const BoundPort& bound) {
        return leads_to(link, to, bound, names, own) && !leads_to(link, to, bound, {}, {});
    });
}

void check_relay(Draft& draft) {
    if (draft.settings.tunnel) check_way(draft, listed_loopback(draft.settings.tunnel->allow));
}

void check_relay(Draft& draft, const std::vector<Network>& own) {
    if (draft.settings.tunnel) check_way(draft, listed_own(draft.settings.tunnel->allow, own));
}

void note_open_ports(Draft& draft) {
    std::string names;
    const Origin* first = nullptr;
    bool can_be_forged = false;
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i) {
        const LinkSettings& link = draft.settings.links[i];
        if (reach_of(link) != Reach::whole_networks) continue;
        if (!first) first = &draft.links[i];
        names += (names.empty() ? "" : ", ") + in_quotes(link.name);
        can_be_forged = can_be_forged || link.kind->carries != Carries::bytes;
    }
    if (first)
        draft.warnings.push_back(
            {first->key("address"),
             "note: " + names + ": any host on the local networks can send commands to this port" +
                 (can_be_forged ? ", and source addresses can be spoofed" : "") +
                 "; on untrusted networks bind a single address, restrict 'allow', and use " +
                 (can_be_forged ? "WireGuard (config/README.md: On a shared Wi-Fi)" : "tls-listen or WireGuard")});
}

}    // namespace anogate
