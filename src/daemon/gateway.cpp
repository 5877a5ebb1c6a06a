#include <daemon/gateway.hpp>
#include <link/kinds.hpp>

#include <spdlog/spdlog.h>

namespace anogate {
namespace {

constexpr Duration required_within = std::chrono::seconds{10};
constexpr Duration stop_look = std::chrono::milliseconds{2};
constexpr Duration datagram_quiet = std::chrono::milliseconds{100};
constexpr Duration stream_quiet = std::chrono::milliseconds{50};

// What the line carries, to know when the rest of a frame is overdue: start bit, eight data bits, parity, stop bits.
std::uint32_t line_rate(const LinkSettings& s) {
    if (s.kind != "serial") return 0;
    const unsigned bits = 9u + (s.serial.parity == Parity::none ? 0u : 1u) + s.serial.stop_bits;
    return std::max(s.serial.baud / bits, 1u);
}

ano::FrameParser::Options parser_options(const LinkSettings& s) {
    const bool datagrams = s.kind == "udp" || s.kind == "udp-listen" || s.kind == "tunnel";
    return {s.max_data, line_rate(s), datagrams ? datagram_quiet : stream_quiet};
}

}  // namespace

Gateway::Gateway(asio::io_context& io, Settings settings)
    : io_{io},
      settings_{std::move(settings)},
      alarms_{io},
      router_{settings_.gateway},
      required_check_{alarms_, [this] {
                          for (const LinkState& s : links_)
                              if (s.link->settings().required && !s.was_up) return on_required_missing_(s.link->name());
                      }},
      stop_check_{alarms_, [this] {
                      if (nothing_waits() || now() >= stop_by_) finish_stop();
                      else stop_check_.set(now_ + stop_look);
                  }} {
    links_.reserve(most_links);
    for (const LinkSettings& link : settings_.links) {
        const LinkId id = router_.add_link({link.id, link.flood, link.broadcast});
        links_.emplace_back().link = make_link(id, link, {io_, alarms_, *this, batch_});
    }
    if (settings_.tunnel) add_tunnel(*settings_.tunnel);
    gpio_ = std::make_unique<Gpio>(io_, alarms_, settings_.gpio,
                                   [this](const std::string& name) -> Link& { return *links_[index(link_named(name))].link; });
    for (const RouteSettings& route : settings_.routes) router_.pin(route.first, route.last, link_named(route.link));
    if (settings_.gateway.unknown == Unknown::link) router_.set_unknown_link(link_named(settings_.gateway.unknown_link));
}

Gateway::~Gateway() = default;

void Gateway::add_tunnel(const TunnelSettings& settings) {
    std::vector<TunnelLink::Target> wrap_to;
    for (const WrapSettings& rule : settings.wrap) {
        const LinkId to = link_named(rule.link);
        wrap_to.push_back({to, links_[index(to)].link->settings().max_data});
    }
    for (const std::string& name : settings.links) tunnelled_.insert(link_named(name));
    const LinkId id = router_.add_link({});
    auto tunnel = std::make_unique<TunnelLink>(id, settings_, std::move(wrap_to), LinkContext{io_, alarms_, *this, batch_}, *this);
    tunnel_ = tunnel.get();
    links_.emplace_back().link = std::move(tunnel);
}

void Gateway::start(std::function<void(const std::string&)> on_required_missing) {
    on_required_missing_ = std::move(on_required_missing);
    started_at_ = now();
    for (LinkState& s : links_) s.since = started_at_;
    gpio_->start();
    for (LinkState& s : links_) s.link->start();
    if (std::any_of(links_.begin(), links_.end(), [](const LinkState& s) { return s.link->settings().required; }))
        required_check_.set(started_at_ + required_within);
}

void Gateway::stop(Duration patience, std::function<void()> on_stopped) {
    if (on_stopped_) {
        if (stop_check_.is_set()) finish_stop();
        return;
    }
    on_stopped_ = std::move(on_stopped);
    required_check_.cancel();
    for (LinkState& s : links_) s.link->stop_reading();
    flush();
    stop_by_ = now() + patience;
    stop_check_.set(now_ + stop_look);    // what was written just now shows in the kernel's counts a moment later
}

Channel* Gateway::open_channel(Link& link, std::string peer) {
    std::size_t i = 0;
    while (i < most_channels && used_.contains(static_cast<ChannelId>(i))) ++i;
    if (i == most_channels) return nullptr;
    const auto id = static_cast<ChannelId>(i);
    const LinkSettings& s = link.settings();
    channels_[i].reset(new Channel{id, link.id(), std::move(peer), ano::FrameParser{parser_options(s)},
                                   Outbox{{s.queue, s.max_data}}, {}, now_, {}, {}});
    used_.insert(id);
    state(link).channels.insert(id);
    router_.open(id, link.id());
    if (!channels_[i]->peer.empty() && state(link).up) spdlog::info("{}: peer {}", link.name(), channels_[i]->peer);
    return channels_[i].get();
}

void Gateway::close_channel(Channel& channel) {
    LinkState& s = links_[index(channel.link)];
    if (s.up) spdlog::info("{}: peer {} is gone", s.link->name(), channel.peer);
    channel.outbox.close();
    add(s.gone_received, channel.received());
    add(s.gone_sent, channel.outbox.counters());
    s.channels.erase(channel.id);
    used_.erase(channel.id);
    to_flush_.erase(channel.id);
    router_.close(channel.id);
    channels_[index(channel.id)].reset();
}

void Gateway::receive(Channel& from, ano::FrameView frame) {
    if (!admit(from, frame)) return;
    if (tunnelled_.contains(from.link) && tunnel_->takes(frame)) return tunnel_->carry(from, frame);
    if (!admit_unopened(from, frame)) return;
    Route route = router_.route(from.id, frame.source(), frame.destination(), now_);
    if (tunnel_ && from.link == tunnel_->id() && is_tunnel_frame(frame)) keep_from_tunnel(route.channels);
    for (const ChannelId to : route.channels) offer(to, frame);
    for (const LinkId to : route.absent) miss(to);
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) ++from.routed.no_route;
    if (route.new_conflict) log_conflict();
}

// A tunnel frame that came inside another one: the next gateway would open it, and the one after that what is in it.
void Gateway::keep_from_tunnel(ChannelSet& channels) {
    const ChannelSet kept = channels & state(*tunnel_).channels;
    if (kept.empty()) return;
    channels -= kept;
    tunnel_->refuse_nested();
}

bool Gateway::admit(Channel& from, ano::FrameView frame) {
    from.heard_at = now_;
    if (gpio_->watches(from.link)) gpio_->heard(from.link, now_);
    if (gpio_->inhibited().contains(from.link) && is_control(frame)) return ++from.routed.inhibited, false;
    return true;
}

// What is inside a tunnel frame that goes on as it is passes nowhere else.
bool Gateway::admit_unopened(Channel& from, ano::FrameView frame) {
    if (!gpio_->inhibited().contains(from.link) || !may_bring_control(frame)) return true;
    ++from.routed.inhibited;
    return false;
}

bool Gateway::may_leave(LinkId, ano::FrameView) { return true; }

void Gateway::learn(Channel& from, ano::FrameView frame) {
    router_.learn(from.id, frame.source(), now_);
    log_conflict();
}

void Gateway::send(LinkId to, ano::FrameView frame) {
    if (links_[index(to)].channels.empty()) miss(to);
    for (const ChannelId channel : links_[index(to)].channels) offer(channel, frame);
}

void Gateway::offer(ChannelId to, ano::FrameView frame) {
    channels_[index(to)]->outbox.push(frame);
    to_flush_.insert(to);
}

// A frame for a link that has no channel now.
void Gateway::miss(LinkId to) {
    ++links_[index(to)].gone_sent.offered;
    ++links_[index(to)].gone_sent.link_down;
}

bool Gateway::is_own_port(std::uint16_t port) const {
    return port != 0 && std::any_of(links_.begin(), links_.end(),
                                    [port](const LinkState& s) { return s.link->local_port() == port; });
}

// A link that is flushed may report a failure, and that may bring frames: until nothing is left to do.
void Gateway::flush() {
    while (!to_flush_.empty()) {
        const ChannelId id = *to_flush_.begin();
        to_flush_.erase(id);
        Channel& channel = *channels_[index(id)];
        if (channel.outbox.empty()) continue;
        if (gpio_->watches(channel.link)) gpio_->sends(channel.link, now_);
        links_[index(channel.link)].link->flush(channel);
    }
}

void Gateway::link_up(Link& link) {
    LinkState& s = state(link);
    for (const ChannelId id : s.channels) channels_[index(id)]->outbox.open();
    if (s.up) return;
    s.up = s.was_up = true;
    s.since = now_;
    s.error.clear();
    gpio_->link_state(link.id(), true);
    spdlog::info("{}: up", link.name());
}

void Gateway::link_down(Link& link, std::string why) {
    LinkState& s = state(link);
    for (const ChannelId id : s.channels) {
        channels_[index(id)]->outbox.close();
        router_.went_down(id, now_);
    }
    if (s.up || s.error != why) spdlog::warn("{}: {}; waiting for it", link.name(), why);
    if (s.up) s.since = now_;
    s.up = false;
    s.error = std::move(why);
    gpio_->link_state(link.id(), false);
}

LinkId Gateway::link_named(const std::string& name) const {
    for (const LinkState& s : links_)
        if (s.link->name() == name) return s.link->id();
    throw std::logic_error("no link is called " + name);    // the configuration was checked for it
}

void Gateway::log_conflict() {
    Conflict conflict;
    while (router_.take_new_conflict(conflict)) {
        std::string names;
        for (const LinkId id : conflict.links) names += (names.empty() ? "" : " and ") + links_[index(id)].link->name();
        spdlog::warn("two devices use the id 0x{:02X}, on {}: give one of them another", conflict.address, names);
    }
}

bool Gateway::nothing_waits() const {
    for (const ChannelId id : used_)
        if (!channels_[index(id)]->outbox.empty()) return false;
    for (const LinkState& s : links_)
        if (s.up && s.link->unsent() > 0) return false;
    return true;
}

void Gateway::finish_stop() {
    stop_check_.cancel();
    for (LinkState& s : links_) s.link->stop();
    gpio_->stop();
    if (on_stopped_) std::exchange(on_stopped_, [] {})();
}

}  // namespace anogate
