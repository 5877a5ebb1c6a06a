#include <config/rule_keys.hpp>

namespace anogate {
namespace {

using namespace key_rows;
using T = TunnelSettings;
using W = WrapSettings;

Value get_ip(const KeyFacts& key, const TunnelSettings& tunnel) {
    if (tunnel.ip) return *tunnel.ip;
    return tunnel.ip_host.empty() ? std::string{key.choices} : tunnel.ip_host;
}

std::string set_ip(const KeyFacts& key, Value value, TunnelSettings& tunnel) {
    const auto* address = std::get_if<IpAddress>(&value);
    tunnel.ip = address ? std::optional{*address} : std::nullopt;
    const auto* text = std::get_if<std::string>(&value);
    tunnel.ip_host = text && *text != key.choices ? *text : "";
    return {};
}

Value get_allow(const KeyFacts&, const TunnelSettings& tunnel) { return NetworkList{false, tunnel.allow, tunnel.allow_hosts}; }

std::string set_allow(const KeyFacts&, Value value, TunnelSettings& tunnel) {
    auto& list = std::get<NetworkList>(value);
    if (list.any) list.networks = {Network{}};
    tunnel.allow = std::move(list.networks);
    tunnel.allow_hosts = std::move(list.hosts);
    return {};
}

Value get_from(const KeyFacts&, const WrapSettings& rule) {
    return rule.from_host.empty() ? Value{rule.from} : Value{rule.from_host};
}

std::string set_from(const KeyFacts&, Value value, WrapSettings& rule) {
    const auto* network = std::get_if<Network>(&value);
    rule.from = network ? *network : Network{};
    rule.from_host = network ? "" : std::get<std::string>(value);
    return {};
}

constexpr std::uint8_t first_tunnel_id = 0xB1;    // the choices of the key are consecutive ids from here on

Value get_as(const KeyFacts& key, const WrapSettings& rule) {
    return std::string{split(key.choices, '|')[static_cast<std::size_t>(rule.id - first_tunnel_id)]};
}

std::string set_as(const KeyFacts& key, Value value, WrapSettings& rule) {
    const auto choices = split(key.choices, '|');
    const auto chosen = std::find(choices.begin(), choices.end(), std::get<std::string>(value)) - choices.begin();
    rule.id = static_cast<std::uint8_t>(first_tunnel_id + chosen);
    return {};
}

constexpr Key<T> own_tunnel_rows[] = {
    row<&T::links>({.name = "links",
                    .form = Form::names,
                    .help = "the links whose tunnel frames (0xB1, 0xB2) are carried over IP",
                    .min = 1,
                    .max = max_name}),
    address<&T::address>("address", first_id, last_id,
                         "tunnel frames to this address, to the gateway's id and to 0xFF are carried"),
    row<&T::bind>({.name = "bind", .form = Form::ip, .help = "the local address of the tunnel port"}),
    integer<&T::port>("port", 0, 65535, "the tunnel port, also used for port 0 in a tunnel frame"),
    Key<T>{{.name = "ip",
            .form = Form::ip,
            .help = "the address under which others reach this gateway; auto: the address that the system uses to reach them",
            .choices = "auto",
            .allows_host_names = true},
           get_ip,
           set_ip},
    choice<&T::deliver>("deliver", "frames|tunnel",
                        "what to send: the inner frames, or the tunnel frame with the gateway's address as its source"),
    Key<T>{{.name = "allow",
            .form = Form::networks,
            .help = "networks and hosts to send to and accept from (default: the local networks, not loopback)",
            .is_v4 = true,
            .allows_host_names = true},
           get_allow,
           set_allow},
    boolean<&T::relay>("relay", "peers of UDP links may reach programs on this computer, if `allow` lists it"),
};

constexpr auto tunnel_rows = own_tunnel_rows + rules_of<T, &T::rules>();

constexpr Key<W> wrap_rows[] = {
    Key<W>{{.name = "from",
            .form = Form::network,
            .help = "wrap datagrams from this network or host into tunnel frames",
            .required = true,
            .is_v4 = true,
            .allows_host_names = true},
           get_from,
           set_from},
    text<&W::link>("link", 1, max_name, "the name of the link to send to") | as("LINK") | needed,
    Key<W>{{.name = "as",
            .form = Form::choice,
            .help = "the kind of tunnel frame, 0xB1 or 0xB2",
            .choices = "ip_tunnel|ip_tunnel_short"},
           get_as,
           set_as},
    address<&W::source>("source", first_id, last_id, "the source of the tunnel frame"),
    address<&W::to>("to", first_id, 255, "the destination of the tunnel frame"),
};

}    // namespace

Keys<TunnelSettings> tunnel_keys() noexcept { return tunnel_rows; }
Keys<WrapSettings> wrap_keys() noexcept { return wrap_rows; }

}    // namespace anogate
