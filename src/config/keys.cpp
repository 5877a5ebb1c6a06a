#include <ano/address.hpp>
#include <config/fields.hpp>
#include <config/keys.hpp>

#include <gateway/ids.hpp>

#include <algorithm>
#include <array>
#include <limits>

namespace anogate {
namespace {

template <class Class, class Member>
Class class_of(Member Class::*);

/// A row for the field that is reached by First and then Rest: <&LinkSettings::serial, &SerialSettings::baud>.
template <auto First, auto... Rest>
constexpr auto row(KeyFacts facts) {
    using Section = decltype(class_of(First));
    return Key<Section>{
        facts, [](const KeyFacts& key, const Section& section) { return write_field(key, ((section.*First).*....*Rest)); },
        [](const KeyFacts& key, std::string_view text, Section& section) {
            return read_field(key, text, ((section.*First).*....*Rest));
        }};
}

template <auto... Path>
constexpr auto boolean(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::boolean, .help = help});
}
template <auto... Path>
constexpr auto integer(std::string_view name, std::uint64_t least, std::uint64_t most, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::integer, .help = help, .least = least, .most = most});
}
template <auto... Path>
constexpr auto address(std::string_view name, std::uint64_t least, std::uint64_t most, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::address, .help = help, .least = least, .most = most});
}
template <auto... Path>
constexpr auto can_id(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::can_id, .help = help, .least = 0, .most = 0x1FFF'FFFF});
}
template <auto... Path>
constexpr auto duration(std::string_view name, std::uint64_t least, std::uint64_t most, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::duration, .help = help, .least = least, .most = most});
}
template <auto... Path>
constexpr auto size(std::string_view name, std::string_view help) {
    constexpr std::uint64_t most = std::uint64_t{1} << 50;
    return row<Path...>({.name = name, .form = Form::size, .help = help, .least = 0, .most = most});
}
template <auto... Path>
constexpr auto choice(std::string_view name, std::string_view choices, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::choice, .help = help, .choices = choices});
}
template <auto... Path>
constexpr auto text(std::string_view name, std::uint64_t least, std::uint64_t most, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::text, .help = help, .least = least, .most = most});
}
template <auto... Path>
constexpr auto frames(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::frames, .help = help});
}
template <auto... Path>
constexpr auto senders(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::senders, .help = help});
}
template <auto... Path>
constexpr auto endpoint(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::endpoint, .help = help});
}

// What is added to a row.

template <class Section>
constexpr Key<Section> operator|(Key<Section> key, auto change) {
    change(key);
    return key;
}
constexpr auto of(std::string_view kinds) {
    return [kinds](KeyFacts& key) { key.kinds = kinds; };
}
constexpr auto by(std::string_view option) {
    return [option](KeyFacts& key) { key.option = option; };
}
constexpr auto as(std::string_view placeholder) {
    return [placeholder](KeyFacts& key) { key.stands_for = placeholder; };
}
constexpr auto needed = [](KeyFacts& key) { key.required = true; };

// Values that fill more than one field.

template <bool UdpListenSettings::*any, std::vector<Network> UdpListenSettings::*networks>
std::optional<std::string> write_networks(const KeyFacts&, const LinkSettings& link) {
    if (link.udp_listen.*any) return "any";
    if ((link.udp_listen.*networks).empty()) return std::nullopt;
    std::string text;
    for (const Network& network : link.udp_listen.*networks) text += (text.empty() ? "" : "+") + network.text();
    return text;
}

template <bool UdpListenSettings::*any, std::vector<Network> UdpListenSettings::*into>
std::string read_networks(const KeyFacts& key, std::string_view text, LinkSettings& link) {
    std::vector<Network> networks;
    if (text != "any") {
        for (const std::string_view word : split(text, '+')) {
            const auto network = Network::parse(word);
            if (!network) return must_be(key, in_quotes(word));
            networks.push_back(*network);
        }
    }
    link.udp_listen.*any = text == "any";
    link.udp_listen.*into = std::move(networks);
    return {};
}

std::optional<std::string> write_hello(const KeyFacts&, const LinkSettings& link) {
    if (!link.hello) return std::nullopt;
    if (*link.hello == LinkSettings::usual_hello) return "on";
    return *link.hello == Duration{} ? "off" : duration_text(*link.hello);
}

std::string read_hello(const KeyFacts& key, std::string_view text, LinkSettings& link) {
    Duration interval = LinkSettings::usual_hello;
    if (const auto on = parse_boolean(text)) interval = *on ? interval : Duration{};
    else if (!read_duration(key, text, interval).empty()) return must_be(key, in_quotes(text));
    link.hello = interval;
    return {};
}

std::optional<std::string> write_unknown(const KeyFacts&, const GatewaySettings& gateway) {
    if (gateway.unknown == Unknown::link) return gateway.unknown_link;
    return gateway.unknown == Unknown::flood ? "flood" : "drop";
}

std::string read_unknown(const KeyFacts& key, std::string_view text, GatewaySettings& gateway) {
    std::string link;
    if (text != "flood" && text != "drop") {
        if (std::string error = read_text(key, text, link); !error.empty()) return error;
    }
    gateway.unknown = text == "flood" ? Unknown::flood : text == "drop" ? Unknown::drop : Unknown::link;
    gateway.unknown_link = link;
    return {};
}

std::optional<std::string> write_addresses(const KeyFacts&, const RouteSettings& route) {
    if (route.last == 0) return std::nullopt;
    return addresses_text({route.first, route.last});
}

std::string read_addresses(const KeyFacts& key, std::string_view text, RouteSettings& route) {
    const auto range = parse_addresses(text);
    if (!range) return must_be(key, in_quotes(text)) + meant_addresses(text);
    if (range->first < key.least || range->last > key.most) return must_be(key, in_quotes(text));
    route.first = range->first;
    route.last = range->last;
    return {};
}

template <class Section>
std::optional<std::string> write_links(const KeyFacts&, const Section& section) {
    std::string text;
    for (const std::string& name : section.links) text += (text.empty() ? "" : "\n") + name;
    return text;
}

template <class Section>
std::string read_links(const KeyFacts& key, std::string_view text, Section& section) {
    std::vector<std::string> links;
    for (const std::string_view name : text.empty() ? std::vector<std::string_view>{} : split(text, '\n')) {
        if (std::string error = read_text(key, name, links.emplace_back()); !error.empty()) return error;
    }
    section.links = std::move(links);
    return {};
}

std::optional<IpAddress> parse_v4(std::string_view text) {
    const auto address = IpAddress::parse(text);
    return address && !address->v6 ? address : std::nullopt;
}

std::optional<Network> parse_v4_network(std::string_view text) {
    const auto network = Network::parse(text);
    return network && !network->address.v6 ? network : std::nullopt;
}

std::optional<std::string> write_bind(const KeyFacts&, const TunnelSettings& tunnel) { return tunnel.bind.text(); }

std::string read_bind(const KeyFacts& key, std::string_view text, TunnelSettings& tunnel) {
    const auto address = parse_v4(text);
    if (!address) return must_be(key, in_quotes(text));
    tunnel.bind = *address;
    return {};
}

std::optional<std::string> write_ip(const KeyFacts&, const TunnelSettings& tunnel) {
    return tunnel.ip ? tunnel.ip->text() : "auto";
}

std::string read_ip(const KeyFacts& key, std::string_view text, TunnelSettings& tunnel) {
    const auto address = parse_v4(text);
    if (text != "auto" && (!address || address->is_any())) return must_be(key, in_quotes(text));
    tunnel.ip = address;
    return {};
}

std::optional<std::string> write_tunnel_allow(const KeyFacts&, const TunnelSettings& tunnel) {
    if (tunnel.allow.empty()) return std::nullopt;
    std::string text;
    for (const Network& network : tunnel.allow) text += (text.empty() ? "" : "+") + network.text();
    return text;
}

std::string read_tunnel_allow(const KeyFacts& key, std::string_view text, TunnelSettings& tunnel) {
    std::vector<Network> networks;
    for (const std::string_view word : split(text == "any" ? "0.0.0.0/0" : text, '+')) {
        const auto network = parse_v4_network(word);
        if (!network) return must_be(key, in_quotes(word));
        networks.push_back(*network);
    }
    tunnel.allow = std::move(networks);
    return {};
}

std::optional<std::string> write_from(const KeyFacts&, const WrapSettings& rule) { return rule.from.text(); }

std::string read_from(const KeyFacts& key, std::string_view text, WrapSettings& rule) {
    const auto network = parse_v4_network(text);
    if (!network) return must_be(key, in_quotes(text));
    rule.from = *network;
    return {};
}

constexpr std::uint8_t first_tunnel_id = 0xB1;    // the choices name the ids from here on

std::optional<std::string> write_as(const KeyFacts& key, const WrapSettings& rule) {
    return std::string{split(key.choices, '|')[static_cast<std::size_t>(rule.id - first_tunnel_id)]};
}

std::string read_as(const KeyFacts& key, std::string_view text, WrapSettings& rule) {
    std::size_t chosen = 0;
    if (std::string error = read_choice(key, text, chosen); !error.empty()) return error;
    rule.id = static_cast<std::uint8_t>(first_tunnel_id + chosen);
    return {};
}

std::optional<std::string> write_silence(const KeyFacts&, const GpioSettings& gpio) {
    if (!gpio.silent_for) return std::nullopt;
    return "silent " + duration_text(*gpio.silent_for);
}

std::string read_silence(const KeyFacts& key, std::string_view text, GpioSettings& gpio) {
    constexpr std::string_view silent = "silent ";
    Duration value{};
    if (!text.starts_with(silent) || !read_duration(key, text.substr(silent.size()), value).empty())
        return must_be(key, in_quotes(text));
    gpio.silent_for = value;
    return {};
}

template <class Section, RuleSettings Section::*rules>
std::optional<std::string> write_limit(const KeyFacts&, const Section& section) {
    std::string text;
    for (const LimitRule& rule : (section.*rules).limit)
        text += (text.empty() ? "" : "\n") + address_text(rule.id) + "=" + rate_text(rule.per_second);
    return text.empty() ? std::nullopt : std::optional{text};
}

// Adds to what was said before.
template <class Section, RuleSettings Section::*rules>
std::string read_limit(const KeyFacts&, std::string_view text, Section& section) {
    std::vector<LimitRule> limit = (section.*rules).limit;
    for (const std::string_view line : split(text, '\n')) {
        LimitText parsed = parse_limit(line);
        if (!parsed.rule) return parsed.error;
        for (const LimitRule& known : limit)
            if (known.id == parsed.rule->id) return address_text(known.id) + " has a limit already";
        limit.push_back(*parsed.rule);
        std::sort(limit.begin(), limit.end(), [](const LimitRule& a, const LimitRule& b) { return a.id < b.id; });
    }
    (section.*rules).limit = std::move(limit);
    return {};
}

// The table.

using G = GatewaySettings;
using L = LinkSettings;
using R = RouteSettings;
using Serial = SerialSettings;
using Listen = UdpListenSettings;
using Can = CanSettings;
using A = AliasSettings;
using T = TunnelSettings;
using W = WrapSettings;
using Rule = RuleSettings;
using F = FilterSettings;

constexpr std::uint64_t first_id = 1, last_id = 254;    // 0x00 and 0xFF are nobody's
constexpr std::uint64_t second = 1000, day = 24 * 3600 * second;
constexpr std::uint64_t max_name = 64, max_path = 4095, max_socket_path = 107, max_interface = 15;

// The rules of links, and of the tunnel, which is one.
constexpr std::size_t rule_rows = 13;
template <class Section, RuleSettings Section::*rules>
constexpr std::array<Key<Section>, rule_rows> rules_of() {
    return {frames<rules, &Rule::receive, &F::allow>("receive.allow", "of what comes in, only these frames are taken"),
            frames<rules, &Rule::receive, &F::deny>("receive.deny", "of what comes in, these frames are not taken"),
            senders<rules, &Rule::receive, &F::allow_sources>("receive.allow_sources", "only from these addresses"),
            senders<rules, &Rule::receive, &F::deny_sources>("receive.deny_sources", "not from these addresses"),
            senders<rules, &Rule::receive, &F::allow_destinations>("receive.allow_destinations", "only to these addresses"),
            senders<rules, &Rule::receive, &F::deny_destinations>("receive.deny_destinations", "not to these addresses"),
            frames<rules, &Rule::send, &F::allow>("send.allow", "only these frames leave"),
            frames<rules, &Rule::send, &F::deny>("send.deny", "these frames do not leave"),
            senders<rules, &Rule::send, &F::allow_sources>("send.allow_sources", "only from these addresses"),
            senders<rules, &Rule::send, &F::deny_sources>("send.deny_sources", "not from these addresses"),
            senders<rules, &Rule::send, &F::allow_destinations>("send.allow_destinations", "only to these addresses"),
            senders<rules, &Rule::send, &F::deny_destinations>("send.deny_destinations", "not to these addresses"),
            Key<Section>{{.name = "limit",
                          .form = Form::limits,
                          .help = "frames a second, at most and evenly spaced, of an id or message: limit.0x01=50"},
                         write_limit<Section, rules>,
                         read_limit<Section, rules>}};
}

template <class Section, std::size_t N, std::size_t M>
constexpr std::array<Key<Section>, N + M> operator+(const Key<Section> (&a)[N], const std::array<Key<Section>, M>& b) {
    std::array<Key<Section>, N + M> all;
    std::copy(std::begin(a), std::end(a), all.begin());
    std::copy(b.begin(), b.end(), all.begin() + N);
    return all;
}

constexpr std::string_view paced = "serial pty can udp udp-listen", datagrams = "udp udp-listen";
constexpr std::string_view one_interface = "hear and send by this network interface alone, such as wg0 (default: any)";

constexpr Key<G> gateway_rows[] = {
    address<&G::id>("id", first_id, last_id, "the gateway's own hardware id (default: none)") | by("--id"),
    text<&G::name>("name", 1, max_name, "the gateway's name in the status") | as("NAME"),
    Key<G>{{.name = "unknown",
            .form = Form::choice_or_link,
            .help = "frames to an address that nobody has used: flood them, drop them, or the one link they go to",
            .least = 1,
            .most = max_name,
            .choices = "flood|drop",
            .option = "--unknown"},
           write_unknown,
           read_unknown},
    duration<&G::forget_after>("forget_after", second, day, "an address not heard for so long is forgotten"),
};

constexpr Key<L> own_link_rows[] = {
    text<&L::serial, &Serial::device>("device", 1, max_path, "path of the port") | as("PATH") | of("serial") | needed,
    integer<&L::serial, &Serial::baud>("baud", 1, std::numeric_limits<std::uint32_t>::max(),
                                       "line rate, any the driver can make") |
        of("serial"),
    choice<&L::serial, &Serial::parity>("parity", "none|even|odd", "parity bit") | of("serial"),
    integer<&L::serial, &Serial::stop_bits>("stop_bits", 1, 2, "stop bits") | of("serial"),
    choice<&L::serial, &Serial::flow>("flow", "none|hardware", "flow control; hardware is RTS/CTS") | of("serial"),
    boolean<&L::serial, &Serial::low_latency>("low_latency", "ask the driver not to collect bytes") | of("serial"),
    choice<&L::serial, &Serial::pace>("pace", "auto|on|off",
                                      "give the port no more than the line carries, so that what is urgent can overtake; auto: "
                                      "not a cdc_acm port, whose baud means nothing") |
        of("serial"),
    boolean<&L::serial, &Serial::dtr>("dtr", "hold the DTR line on or off (default: as the driver sets it)") | of("serial"),
    boolean<&L::serial, &Serial::rts>("rts", "hold the RTS line on or off (default: as the driver sets it)") | of("serial"),

    endpoint<&L::udp_listen, &Listen::local>("address", "local IP:PORT to listen on") | of("udp-listen") | needed,
    text<&L::udp_listen, &Listen::interface>("interface", 1, max_interface, one_interface) | of("udp-listen"),
    duration<&L::udp_listen, &Listen::peer_timeout>(
        "peer_timeout", second, day, "a peer silent for so long is forgotten; a host of our networks may listen for an hour") |
        of("udp-listen"),
    integer<&L::udp_listen, &Listen::max_peers>("max_peers", 1, max_channels,
                                                "most peers at a time; one that is silent gives way") |
        of("udp-listen"),
    integer<&L::udp_listen, &Listen::max_per_address>("max_per_address", 1, max_channels,
                                                      "most peers of one IP address, loopback excepted (default: a quarter of "
                                                      "max_peers, two at least)") |
        of("udp-listen"),
    Key<L>{{.name = "allow",
            .form = Form::networks,
            .help = "networks whose members may become peers, or any (default: the networks of our interfaces)",
            .kinds = "udp-listen"},
           write_networks<&Listen::allow_any, &Listen::allow>,
           read_networks<&Listen::allow_any, &Listen::allow>},
    Key<L>{{.name = "trusted",
            .form = Form::networks,
            .help = "networks outside those of our interfaces whose peers are sent to at once, or any; others get at most three "
                    "times what they send, until they answer (default: none)",
            .kinds = "udp-listen"},
           write_networks<&Listen::trusted_any, &Listen::trusted>,
           read_networks<&Listen::trusted_any, &Listen::trusted>},

    endpoint<&L::udp, &UdpSettings::peer>("address", "the peer's IP:PORT") | of("udp") | needed,
    endpoint<&L::udp, &UdpSettings::bind>("bind", "local IP:PORT to send from (default: the system chooses)") | of("udp"),
    text<&L::udp, &UdpSettings::interface>("interface", 1, max_interface, one_interface) | of("udp"),

    text<&L::can, &Can::interface>("interface", 1, max_interface, "the CAN interface; its bit rate is the system's business") |
        of("can") | needed,
    choice<&L::can, &Can::framing>("framing", "stream|isotp",
                                   "stream: the bytes of each frame in CAN frames under the sender's id; isotp: each frame "
                                   "one ISO-TP PDU, for one peer device") |
        of("can"),
    boolean<&L::can, &Can::fd>("fd", "CAN FD frames of up to 64 bytes") | of("can"),
    boolean<&L::can, &Can::brs>("brs", "with fd: data at the faster bit rate") | of("can"),
    boolean<&L::can, &Can::extended>("extended", "29-bit CAN ids") | of("can"),
    can_id<&L::can, &Can::base>("base",
                                "first CAN id of stream framing, a multiple of 0x100 up to 0x700, or of 0x40000 with "
                                "extended (default: 0x600, extended 0x0AB00000)") |
        of("can"),
    can_id<&L::can, &Can::tx>("tx", "with isotp: the CAN id that we send by (default: none)") | of("can"),
    can_id<&L::can, &Can::rx>("rx", "with isotp: the CAN id that we receive by (default: none)") | of("can"),

    text<&L::pty, &PtySettings::path>("path", 1, max_path, "the link that is made to the pseudo-terminal") | as("PATH") |
        of("pty") | needed,

    choice<&L::sim, &SimSettings::device>("device", "fc", "the device to simulate") | of("sim") | needed,
    integer<&L::sim, &SimSettings::hz>("hz", 1, 100, "attitude frames a second; slower ones keep their proportion") | of("sim"),

    text<&L::name>("name", 1, max_name, "what the link is called (default: last part of the path, or kind-port)") | as("NAME"),
    address<&L::id>("id", 1, ano::address::last_port_id, "port id: frames to this address leave by this link (default: none)"),
    choice<&L::profile>("profile", "none|vendor",
                        "what the devices there stand; vendor, the maker's newest library: max_data_out=198, hello=on, "
                        "value_type_7=u64, encoding=gbk, no frame without DATA, at most 8 questions not answered yet"),
    integer<&L::max_data>("max_data", 0, 65535, "most bytes of DATA in a frame that comes in; longer ones are refused"),
    integer<&L::max_data_out>("max_data_out", 0, 65535,
                              "most bytes of DATA in a frame that leaves (default: max_data, with profile=vendor 198 at most)"),
    Key<L>{{.name = "hello",
            .form = Form::interval,
            .help = "while nothing comes in, asks who is there (0xE0 0 from 0xFE): first after 1 s, then so often, on is 2s "
                    "(default: off, with profile=vendor on); not on udp-listen",
            .least = second,
            .most = day},
           write_hello,
           read_hello},
    choice<&L::value_type_7>("value_type_7", "f32|u64",
                             "for tools: what type 7 of a command's value means (default: f32, with profile=vendor u64)"),
    choice<&L::encoding>("encoding", "utf8|gbk",
                         "for tools: what text on this link is written in (default: utf8, with profile=vendor gbk)"),
    integer<&L::queue>("queue", 8, 64 << 20, "most bytes waiting to leave by a channel, at least max_data_out + 8"),
    boolean<&L::flood>("flood", "takes frames to addresses that nobody has used"),
    boolean<&L::broadcast>("broadcast", "takes frames to 0xFF"),
    text<&L::group>("group", 1, max_name,
                    "links of one group lead to the same place: one carries, copies are dropped (default: none)") |
        as("GROUP"),
    address<&L::present_as>("present_as", first_id, last_id,
                            "for devices that answer 0xFE only: hosts of another address appear there under this one, and "
                            "answers go to who asked (default: none)"),
    integer<&L::rate>("rate", 1, 1'000'000'000, "most bytes a second to leave, for a slow radio behind it (default: no limit)") |
        of(paced),
    duration<&L::latency>("latency", 1, second, "how far a paced link may be ahead of its line") | of(paced),
    boolean<&L::pack>("pack", "several frames share a datagram when they wait anyway") | of(datagrams),
    integer<&L::mtu>("mtu", 64, 65507, "most bytes in a datagram of several frames") | of(datagrams),
    duration<&L::age, &AgeLimits::control>("age.control", 1, day, "sticks (0x40, 0x41) that waited longer are dropped"),
    duration<&L::age, &AgeLimits::telemetry>("age.telemetry", 1, day, "telemetry that waited longer is dropped"),
    duration<&L::age, &AgeLimits::rest>("age.rest", 1, day, "any other frame that waited longer is dropped"),
    boolean<&L::required>("required", "the program ends with 1 when this link is not up within 10 s"),
};

constexpr auto link_rows = own_link_rows + rules_of<L, &L::rules>();

constexpr Key<A> alias_rows[] = {
    text<&A::link>("link", 1, max_name, "the name of the link that the device is behind") | as("LINK") | needed,
    address<&A::device>("device", first_id, last_id, "the id that the device has") | needed,
    address<&A::as>("as", first_id, last_id, "the id under which all others see it") | needed,
};

constexpr Key<R> route_rows[] = {
    Key<R>{{.name = "address",
            .form = Form::addresses,
            .help = "the address or range to pin",
            .least = first_id,
            .most = last_id,
            .required = true},
           write_addresses,
           read_addresses},
    text<&R::link>("link", 1, max_name, "the name of the link that leads there") | as("LINK") | needed,
};

constexpr Key<T> own_tunnel_rows[] = {
    Key<T>{{.name = "links",
            .form = Form::names,
            .help = "the links whose tunnel frames (0xB1, 0xB2) are carried over IP",
            .least = 1,
            .most = max_name},
           write_links<T>,
           read_links<T>},
    address<&T::address>("address", first_id, last_id,
                         "tunnel frames to this address, to the gateway's id and to 0xFF are carried"),
    Key<T>{{.name = "bind", .form = Form::ip, .help = "the local address of the tunnel port"}, write_bind, read_bind},
    integer<&T::port>("port", 0, 65535, "the tunnel port, and what port 0 in a tunnel frame means"),
    Key<T>{{.name = "ip",
            .form = Form::ip,
            .help = "our address as others know it, or auto: the one the system uses towards them",
            .choices = "auto"},
           write_ip,
           read_ip},
    choice<&T::deliver>("deliver", "frames|tunnel",
                        "what leaves: the frames inside, or the tunnel frame with our address as its source"),
    Key<T>{{.name = "allow",
            .form = Form::networks,
            .help = "networks that may be sent to and may send (default: the networks of our interfaces, not loopback)"},
           write_tunnel_allow,
           read_tunnel_allow},
    boolean<&T::relay>("relay", "peers of UDP links may reach programs on this computer, where `allow` lists it"),
};

constexpr auto tunnel_rows = own_tunnel_rows + rules_of<T, &T::rules>();

constexpr Key<W> wrap_rows[] = {
    Key<W>{{.name = "from",
            .form = Form::network,
            .help = "what comes from this network is wrapped into a tunnel frame",
            .required = true},
           write_from,
           read_from},
    text<&W::link>("link", 1, max_name, "the name of the link that gets it") | as("LINK") | needed,
    Key<W>{{.name = "as",
            .form = Form::choice,
            .help = "the kind of tunnel frame, 0xB1 or 0xB2",
            .choices = "ip_tunnel|ip_tunnel_short"},
           write_as,
           read_as},
    address<&W::source>("source", first_id, last_id, "the tunnel frame's source"),
    address<&W::to>("to", first_id, 255, "the tunnel frame's destination"),
};

using P = GpioSettings;
constexpr std::uint64_t max_line_name = 31;    // the kernel's

constexpr Key<P> gpio_rows[] = {
    text<&P::chip>("chip", 1, max_path, "the chip by name, path or label; not needed for a line's name that only one chip has") |
        as("gpiochip0"),
    row<&P::line>({.name = "line",
                   .form = Form::line,
                   .help = "the line by its number on the chip, or by name",
                   .least = 1,
                   .most = max_line_name,
                   .required = true}),
    choice<&P::use>("use", "link_up|activity|power|reset|inhibit|rs485",
                    "on while the link is up, blinks with its traffic, switches power, pulses a reset, keeps control frames off, "
                    "or turns an RS-485 transceiver to sending") |
        needed,
    text<&P::link>("link", 1, max_name, "the name of the link it is for") | as("LINK"),
    Key<P>{{.name = "links",
            .form = Form::names,
            .help = "the links whose control frames are kept off while the line is active",
            .least = 1,
            .most = max_name,
            .kinds = "inhibit"},
           write_links<P>,
           read_links<P>},
    boolean<&P::active_low>("active_low", "the line is active when it is low"),
    choice<&P::bias>("bias", "as_is|disabled|pull_up|pull_down", "the resistor inside the chip"),
    duration<&P::pulse>("pulse", 1, 60 * second, "how long a reset is active, or power is off (default: 100ms, power 1s)") |
        of("power reset"),
    Key<P>{{.name = "when",
            .form = Form::silence,
            .help = "a reset by itself, when the link had no good frame for so long; at most one a minute",
            .least = second,
            .most = day,
            .kinds = "reset"},
           write_silence,
           read_silence},
};

constexpr Key<ControlSettings> control_rows[] = {
    text<&ControlSettings::socket>("socket", 0, max_socket_path,
                                   "path of the control socket, or none (default: /run/anogate/control.sock, "
                                   "for users $XDG_RUNTIME_DIR/anogate.sock)") |
        as("PATH|none") | by("--control"),
};

constexpr Key<LogSettings> log_rows[] = {
    choice<&LogSettings::level>("level", "trace|debug|info|warn|error", "what is logged") | by("--log-level"),
    text<&LogSettings::file>("file", 0, max_path, "where to (default: standard error)") | as("PATH"),
    size<&LogSettings::rotate>("rotate", "a log file of this size is put aside and a new one begun; 0: never"),
};

}    // namespace

Keys<GatewaySettings> gateway_keys() noexcept { return gateway_rows; }
Keys<LinkSettings> link_keys() noexcept { return link_rows; }
Keys<RouteSettings> route_keys() noexcept { return route_rows; }
Keys<AliasSettings> alias_keys() noexcept { return alias_rows; }
Keys<TunnelSettings> tunnel_keys() noexcept { return tunnel_rows; }
Keys<WrapSettings> wrap_keys() noexcept { return wrap_rows; }
Keys<GpioSettings> gpio_keys() noexcept { return gpio_rows; }
Keys<ControlSettings> control_keys() noexcept { return control_rows; }
Keys<LogSettings> log_keys() noexcept { return log_rows; }

}    // namespace anogate
