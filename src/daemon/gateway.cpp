#include <ano/address.hpp>
#include <daemon/gateway.hpp>
#include <gateway/pacer.hpp>
#include <link/kinds.hpp>

#include <spdlog/spdlog.h>

namespace anogate {
namespace {

constexpr Duration required_within = std::chrono::seconds{10};
constexpr Duration stop_look = std::chrono::milliseconds{10};
constexpr Duration datagram_quiet = std::chrono::milliseconds{100};
constexpr Duration stream_quiet = std::chrono::milliseconds{50};

// What the line carries, to know when the rest of a frame is overdue.
std::uint32_t line_rate(const LinkSettings& s) {
    return s.kind == "serial" ? uart_rate(s.serial.baud, s.serial.parity != Parity::none, s.serial.stop_bits) : 0;
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
      peer_log_{alarms_},
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
    add_links();
    if (settings_.tunnel) add_tunnel(*settings_.tunnel);
    add_aliases();
    gpio_ = std::make_unique<Gpio>(io_, alarms_, settings_.gpio,
                                   [this](const std::string& name) -> Link& { return *links_[index(link_named(name))].link; });
    for (const RouteSettings& route : settings_.routes) router_.pin(route.first, route.last, link_named(route.link));
    if (settings_.gateway.unknown == Unknown::link) router_.set_unknown_link(link_named(settings_.gateway.unknown_link));
}

Gateway::~Gateway() = default;

void Gateway::add_links() {
    std::vector<std::string> groups{""};
    for (const LinkSettings& link : settings_.links) {
        auto group = std::find(groups.begin(), groups.end(), link.group);
        if (group == groups.end()) group = groups.insert(group, link.group);
        const auto number = static_cast<std::uint8_t>(group - groups.begin());
        const LinkId id = router_.add_link({link.id, link.flood, link.broadcast, number});
        LinkState& added = links_.emplace_back();
        added.link = make_link(id, link, {io_, alarms_, *this, batch_, sender_});
        added.group = number;
        give_rules(added, link.rules);
    }
}

void Gateway::give_rules(LinkState& link, const RuleSettings& settings) {
    if (settings == RuleSettings{}) return;
    link.rules = std::make_unique<Rules>(settings);
    ruled_.insert(link.link->id());
}

void Gateway::add_aliases() {
    for (const LinkState& s : links_) {
        std::vector<AliasRule> rules;
        for (const AliasSettings& alias : settings_.aliases)
            if (alias.link == s.link->name()) rules.push_back({alias.device, alias.as});
        if (rules.empty()) continue;
        for (const AliasRule& rule : rules) router_.pin(rule.as, rule.as, s.link->id());    // it is nowhere else
        links_[index(s.link->id())].aliases = std::make_unique<Aliases>(rules, s.link->settings().max_data);
        ruled_.insert(s.link->id());
    }
}

void Gateway::add_tunnel(const TunnelSettings& settings) {
    std::vector<TunnelLink::Target> wrap_to;
    for (const WrapSettings& rule : settings.wrap) {
        const LinkId to = link_named(rule.link);
        wrap_to.push_back({to, links_[index(to)].link->settings().max_data});
    }
    for (const std::string& name : settings.links) tunnelled_.insert(link_named(name));
    const LinkId id = router_.add_link({});
    auto tunnel = std::make_unique<TunnelLink>(id, settings_, std::move(wrap_to), LinkContext{io_, alarms_, *this, batch_, sender_}, *this);
    tunnel_ = tunnel.get();
    links_.emplace_back().link = std::move(tunnel);
    give_rules(links_.back(), settings.rules);
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
                                   Outbox{{s.queue, s.max_data, s.age}}, {}, now_, {}, {}, false, {}});
    used_.insert(id);
    state(link).channels.insert(id);
    router_.open(id, link.id());
    loop_guard_.open(id, link.id(), now_);
    if (!channels_[i]->peer.empty() && state(link).up) peer_log_.came(link.name(), channels_[i]->peer, now_);
    return channels_[i].get();
}

void Gateway::close_channel(Channel& channel) {
    LinkState& s = links_[index(channel.link)];
    if (s.up) peer_log_.went(s.link->name(), channel.peer, now_);
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
    ++frame_number_;
    from.heard_at = now_;
    if (gpio_->watches(from.link)) gpio_->heard(from.link, now_);
    const Treatment treatment = treatment_of(frame.id());
    const ano::FrameView brought = frame;
    if (Aliases* aliases = links_[index(from.link)].aliases.get()) frame = aliases->inbound(frame, treatment, now_);
    if (came_before(from, frame, brought, treatment)) return;
    if (!asked_by_many(frame) && loop_guard_.copied(key_of(frame), from.id, now_)) return void(++from.routed.looped);
    if (!admit(from, frame)) return;
    if (tunnelled_.contains(from.link) && tunnel_->takes(frame)) return tunnel_->carry(from, frame);
    if (!admit_unopened(from, frame)) return;
    Route route = router_.route(from.id, frame.source(), frame.destination(), now_);
    if (tunnel_ && from.link == tunnel_->id() && is_tunnel_frame(frame)) keep_from_tunnel(route);
    if (!route.guarded.empty()) loop_guard_.remember(key_of(frame), from.id, route.guarded, now_);
    for (const ChannelId to : route.channels) offer(to, frame, treatment);
    for (const LinkId to : route.absent) refuse(to, &SendCounters::link_down);
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) ++from.routed.no_route;
    if (route.new_conflict) log_conflict();
}

// Our own, come back by another way, or a copy of one that another link of the group brought: that is told by what was
// `brought`, before its alias.
bool Gateway::came_before(Channel& from, ano::FrameView frame, ano::FrameView brought, Treatment treatment) {
    const std::uint64_t key = key_of(frame);
    const std::uint8_t group = links_[index(from.link)].group;
    const bool common = asked_by_many(frame);
    if (loop_guard_.looped(key, from.id, now_, common)) {
        ++from.routed.looped;
        if (common && !loop_guard_.suspect(from.id, now_)) learn(from, frame);    // the answer is for this one as well
        return true;
    }
    if (group == 0 || !duplicates_.duplicate(key_of(brought), group, from.link, treatment.replaces, now_)) return false;
    ++from.routed.duplicate;
    return true;
}

// A tunnel frame that came inside another one: the next gateway would open it, and the one after that what is in it.
void Gateway::keep_from_tunnel(Route& route) {
    const ChannelSet kept = route.channels & state(*tunnel_).channels;
    if (kept.empty()) return;
    route.channels -= kept;
    route.guarded -= kept;
    tunnel_->refuse_nested();
}

bool Gateway::admit(Channel& from, ano::FrameView frame) {
    from.heard_at = now_;
    const Rules* rules = links_[index(from.link)].rules.get();
    if (rules && !rules->takes(frame)) return ++from.routed.denied_in, false;
    if (gpio_->inhibited().contains(from.link) && is_control(frame)) return ++from.routed.inhibited, false;
    return true;
}

// What is inside a tunnel frame that goes on as it is passes nowhere else.
bool Gateway::admit_unopened(Channel& from, ano::FrameView frame) {
    if (!gpio_->inhibited().contains(from.link) || !may_bring_control(frame)) return true;
    ++from.routed.inhibited;
    return false;
}

bool Gateway::goes_once(Channel& from, ano::FrameView frame, LinkId to) {
    const std::uint64_t key = key_of(frame);
    const bool common = asked_by_many(frame);
    if (loop_guard_.looped(key, from.id, now_, common) || (!common && loop_guard_.copied(key, from.id, now_)))
        return ++from.routed.looped, false;
    loop_guard_.remember(key, from.id, links_[index(to)].channels, now_);
    return true;
}

bool Gateway::may_leave(LinkId to, ano::FrameView frame) {
    Rules* rules = links_[index(to)].rules.get();
    const auto cause = rules ? rules->refusal(frame, ++frame_number_, now_) : nullptr;
    if (cause) refuse(to, cause);
    return !cause;
}

void Gateway::learn(Channel& from, ano::FrameView frame) {
    router_.learn(from.id, frame.source(), now_);
    log_conflict();
}

void Gateway::send(LinkId to, ano::FrameView frame) {
    ++frame_number_;
    if (links_[index(to)].channels.empty()) refuse(to, &SendCounters::link_down);
    for (const ChannelId channel : links_[index(to)].channels) offer(channel, frame, treatment_of(frame.id()));
}

void Gateway::say(ChannelId to, ano::FrameView frame) {
    ++frame_number_;
    offer(to, frame, treatment_of(frame.id()));
}

void Gateway::offer(ChannelId to, ano::FrameView frame, Treatment treatment) {
    Channel& channel = *channels_[index(to)];
    channel.hosts_spoke = channel.hosts_spoke || ano::address::is_host(frame.source());
    if (ruled_.contains(channel.link)) {
        const LinkState& link = links_[index(channel.link)];
        const auto cause = link.rules ? link.rules->refusal(frame, frame_number_, now_) : nullptr;
        const auto seen = link.aliases ? link.aliases->outbound(frame, treatment, now_) : std::optional{frame};
        if (cause || !seen) return channel.outbox.refuse(cause ? cause : &SendCounters::denied_out);
        frame = *seen;
    }
    channel.outbox.push(frame, treatment, now_);
    to_flush_.insert(to);
}

// A frame that was for the link and for none of its channels.
void Gateway::refuse(LinkId to, std::uint64_t SendCounters::*cause) {
    ++links_[index(to)].gone_sent.offered;
    ++(links_[index(to)].gone_sent.*cause);
}

bool Gateway::is_own_port(std::uint16_t port) const {
    return port != 0 && std::any_of(links_.begin(), links_.end(),
                                    [port](const LinkState& s) { return s.link->local_port() == port; });
}

bool Gateway::listens_at(std::uint16_t port) const {
    return std::any_of(links_.begin(), links_.end(), [port](const LinkState& s) {
        const std::string& kind = s.link->settings().kind;
        return (kind == "udp-listen" || kind == "tunnel") && s.link->local_port() == port;
    });
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
    for (const ChannelId id : s.channels) {
        channels_[index(id)]->outbox.open();
        router_.came_up(id);
    }
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
    peer_log_.finish();
    for (LinkState& s : links_) s.link->stop();
    gpio_->stop();
    if (on_stopped_) std::exchange(on_stopped_, [] {})();
}

}  // namespace anogate
