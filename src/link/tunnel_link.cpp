#include <config/link_kind.hpp>
#include <gateway/loop_guard.hpp>
#include <link/resolver.hpp>
#include <link/tunnel_link.hpp>
#include <link/udp/udp_settings.hpp>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace anogate {
namespace {

// Not in the list of kinds: it can't be configured as a link.
constinit const LinkKind tunnel_kind{.name = "tunnel", .carries = Carries::datagrams, .listens = true};

constexpr Duration hosts_slack = std::chrono::seconds{1};
constexpr Duration without_address = std::chrono::seconds{5};    // until the next look-up: the network may come up

HostAddresses hosts_in(const TunnelSettings& settings) {
    HostAddresses hosts;
    for (const std::string& host : settings.allow_hosts) hosts[host];
    for (const WrapSettings& rule : settings.wrap)
        if (!rule.from_host.empty()) hosts[rule.from_host];
    if (!settings.ip_host.empty()) hosts[settings.ip_host];
    return hosts;
}

}    // namespace

// Accepts frames as large as the largest max_data of our links, limited by the size of a datagram.
LinkSettings TunnelLink::link_settings(const Settings& settings) {
    LinkSettings link;
    link.kind = &tunnel_kind;
    link.name = tunnel_kind.name;
    for (const LinkSettings& other : settings.links) link.max_data = std::max(link.max_data, other.max_data);
    link.max_data = std::min(link.max_data, static_cast<std::uint16_t>(max_datagram - ano::overhead));
    link.queue = std::max(link.queue, 2 * (static_cast<std::uint32_t>(ano::overhead) + link.max_data));
    UdpListenSettings listen;
    listen.local = {{settings.tunnel->bind, settings.tunnel->port}};
    link.of_kind = std::move(listen);
    link.rules = settings.tunnel->rules;
    return link;
}

TunnelLink::TunnelLink(LinkId id, const Settings& settings, std::vector<Target> wrap_to, const LinkContext& context,
                       Forwarder& forwarder)
    : UdpListenLink{id, link_settings(settings), context},
      forwarder_{forwarder},
      tunnel_{*settings.tunnel,
              settings.gateway.id,
              {[this](const IpAddress& there) { return our_address(there); },
               [this](std::uint16_t port) { return this->context().host.is_own_port(port); }}},
      wrap_to_{std::move(wrap_to)},
      hosts_{hosts_in(*settings.tunnel)},
      look_up_{context.alarms, [this] { look_up_hosts(); }, hosts_slack} {}

void TunnelLink::carry(Channel& from, ano::FrameView frame) {
    const TimePoint now = context().host.now();
    refresh_networks(now);
    forwarder_.learn(from, frame, now);
    const auto passes = [&](ano::FrameView inner) { return forwarder_.passes_into_tunnel(from, inner, now); };
    const auto datagram = tunnel_.out(frame, passes);
    if (!datagram) return;
    if (!is_open()) return tunnel_.refuse(&TunnelCounters::tunnel_down);
    switch (send(datagram->to, datagram->bytes)) {
    case 0: return tunnel_.sent();
    case EMSGSIZE: return tunnel_.refuse(&TunnelCounters::tunnel_too_big);
    default: return tunnel_.refuse(&TunnelCounters::tunnel_send_failed);
    }
}

void TunnelLink::opened(const Endpoint& local) {
    tunnel_.set_port(local.port);
    if (!hosts_.empty()) look_up_hosts();
}

// A name keeps its addresses if a later look-up fails.
void TunnelLink::look_up_hosts() {
    look_up_.set(context().host.now() + context().names.kept_for());
    no_such_host_ = {};
    for (const auto& [host, known] : hosts_)
        context().names.resolve(host, context().host.now(), this, [this, &name = host](const auto& addresses, const auto& fault) {
            if (!addresses.empty()) {
                hosts_[name] = addresses;
                last_path_.reset();
                tunnel_.set_hosts(hosts_);
            } else if (hosts_[name].empty()) {
                no_such_host_ = no_such_host(name, fault);
                look_up_.set(context().host.now() + without_address);
            }
        });
}

void TunnelLink::stop_looking_up() {
    look_up_.cancel();
    context().names.cancel(this);
}

void TunnelLink::stop_reading() {
    stop_looking_up();
    UdpListenLink::stop_reading();
}

void TunnelLink::stop() {
    stop_looking_up();
    UdpListenLink::stop();
}

bool TunnelLink::allowed(const Endpoint& sender, TimePoint now) {
    refresh_networks(now);
    if (!tunnel_.admits(sender)) return false;
    before_stranger_ = tunnel_.counters();
    return true;
}

// A check only: restores the counters, because deliver() counts an accepted frame.
bool TunnelLink::welcomes(const Endpoint& sender, ano::FrameView frame) {
    if (is_tunnel_frame(frame) && !tunnel_.in(frame, sender.address, [](ano::FrameView) {})) return false;
    tunnel_.set_counters(before_stranger_);
    return true;
}

void TunnelLink::deliver(Channel& channel, const Endpoint& sender, ano::FrameView frame) {
    if (!is_tunnel_frame(frame)) return pass_on(channel, sender, frame);
    const TimePoint now = context().host.now();
    refresh_networks(now);
    if (!forwarder_.admit(channel, frame, now)) return;
    tunnel_.in(frame, sender.address, [&](ano::FrameView inner) { pass_on(channel, sender, inner); });
}

// A tunnel frame inside a tunnel frame is treated as data. Probes are not wrapped: they are not for devices.
void TunnelLink::pass_on(Channel& channel, const Endpoint& sender, ano::FrameView frame) {
    has_accepted_ = true;
    if (const auto rule = tunnel_.wrap_rule(sender.address); rule && !is_probe(frame)) wrap(*rule, channel, sender, frame);
    else context().host.receive(channel, frame);
}

void TunnelLink::wrap(std::size_t rule, Channel& channel, const Endpoint& sender, ano::FrameView frame) {
    const Target& to = wrap_to_[rule];
    const TimePoint now = context().host.now();
    if (!tunnel_.can_wrap() || !forwarder_.passes_to_wrap(channel, frame, to.link, now)) return;
    if (!tunnel_.wrapping()) {
        refresh_networks(now);
        if (!tunnel_.begin_wrap(rule, to.max_data, sender)) return;
    }
    tunnel_.add_to_wrap(frame, [&](ano::FrameView full) { forwarder_.send(to.link, full, now); });
}

void TunnelLink::delivered() {
    if (std::exchange(has_accepted_, false)) tunnel_.came_in();
    const auto rule = tunnel_.wrapping();
    tunnel_.end_wrap([&](ano::FrameView full) { forwarder_.send(wrap_to_[*rule].link, full, context().host.now()); });
}

void TunnelLink::refresh_networks(TimePoint now) {
    if (!seen_networks_.refresh(now)) return;
    last_path_.reset();
    tunnel_.set_networks(seen_networks_.all());
}

std::optional<IpAddress> TunnelLink::our_address(const IpAddress& there) {
    const TunnelSettings& settings = tunnel_.settings();
    if (tunnel_.has_ip()) return tunnel_.ip();
    if (!settings.bind.is_any()) return settings.bind;
    if (!last_path_ || last_path_->there != there) last_path_ = {there, source_towards(there)};
    return last_path_->source;
}

LinkFacts TunnelLink::facts() const {
    LinkFacts facts = UdpListenLink::facts();
    const TunnelSettings& settings = tunnel_.settings();
    const auto ip = tunnel_.has_ip() ? tunnel_.ip() : settings.bind.is_any() ? source_towards({}) : std::optional{settings.bind};
    if (ip) facts.push_back({"ip", ip->text()});
    return facts;
}

}    // namespace anogate
