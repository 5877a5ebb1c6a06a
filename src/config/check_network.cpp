#include <config/check_network.hpp>
#include <config/link_kind.hpp>
#include <gateway/tunnel/tunnel_policy.hpp>

#include <algorithm>

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

}    // namespace

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
