#include <config/config.hpp>
#include <config/link_kind.hpp>
#include <link/clocks.hpp>
#include <log/log_line.hpp>
#include <runtime/conflict_log.hpp>
#include <runtime/control_link.hpp>
#include <runtime/forwarder_link.hpp>
#include <runtime/gateway.hpp>

#include <algorithm>
#include <random>
#include <stdexcept>

namespace anogate {
namespace {

constexpr Duration required_within = std::chrono::seconds{10};
constexpr Duration stop_look = std::chrono::milliseconds{10};
constexpr Duration hello_slack = std::chrono::milliseconds{100};
constexpr Duration brief = std::chrono::seconds{1};

std::uint64_t number_of_its_own() {
    std::random_device random;
    return std::uint64_t{random()} << 32 | random();
}

WireIdentity wire_of(const Link& link) {
    const StorableLink* const storable = link.as<StorableLink>();
    return WireIdentity::of(storable ? storable->storable_wire() : -1);
}

}    // namespace

Gateway::Gateway(asio::io_context& io, Settings settings)
    : io_{io},
      settings_{std::move(settings)},
      alarms_{io},
      peer_log_{alarms_},
      forwarder_{settings_.gateway, number_of_its_own()},
      beat_{alarms_, [this] { beat(); }},
      forwarder_due_{alarms_,
                     [this] {
                         forwarder_.tick(now());
                         flush();
                     }},
      hello_due_{alarms_,
                 [this] {
                     forwarder_.send_hellos(now());
                     flush();
                 },
                 hello_slack},
      required_check_{alarms_, [this] { check_required(); }},
      log_up_later_{alarms_, [this] { log_up(); }},
      stop_check_{alarms_, [this] { check_stop(); }},
      change_check_{alarms_, [this] { check_change(); }} {
    links_.reserve(max_links);
    LinkSet all;
    for (const LinkSettings& link : settings_.links) all.insert(add_link(link));
    if (settings_.tunnel) all.insert(add_tunnel());
    if (is_control_configured(settings_)) all.insert(add_control());
    gpio_ = std::make_unique<Gpio>(io_, alarms_, forwarder_.inhibit());
    gpio_->change(
        settings_.gpio, [this](const std::string& name) -> Link& { return link_named(name); }, all);
    forwarder_.set_classes(settings_.classes);
    pin_routes();
}

Gateway::~Gateway() = default;

// The links of a group share a number while the group has links.
std::uint8_t Gateway::group_number(const std::string& group) {
    const auto is_unused = [this](const std::string& name) {
        return std::none_of(links_.begin(), links_.end(), [&](const LinkState& s) { return s.link->settings().group == name; });
    };
    auto place = std::find(groups_.begin(), groups_.end(), group);
    if (place == groups_.end()) place = std::find_if(groups_.begin() + 1, groups_.end(), is_unused);
    if (place == groups_.end()) place = groups_.insert(place, group);
    *place = group;
    return static_cast<std::uint8_t>(place - groups_.begin());
}

LinkId Gateway::add_link(const LinkSettings& link) {
    const LinkId id = forwarder_.add_link(forwarder_link(link, group_number(link.group), settings_.aliases));
    add(link.kind->make(id, link, {io_, alarms_, *this, batch_, sender_, names_, v7_lines_}));
    if (link.kind->carries == Carries::bytes) streams_.insert(id);
    return id;
}

LinkId Gateway::add_tunnel() {
    const LinkId id = forwarder_.add_link(forwarder_link(TunnelLink::link_settings(settings_), 0, {}));
    auto tunnel = std::make_unique<TunnelLink>(id, settings_, wrap_targets(),
                                               LinkContext{io_, alarms_, *this, batch_, sender_, names_, v7_lines_}, forwarder_);
    tunnel_ = tunnel.get();
    add(std::move(tunnel));
    connect_tunnel();
    return id;
}

std::vector<TunnelLink::Target> Gateway::wrap_targets() const {
    std::vector<TunnelLink::Target> targets;
    for (const WrapSettings& rule : settings_.tunnel->wrap) {
        const Link& to = link_named(rule.link);
        targets.push_back({to.id(), to.settings().effective_max_data_out()});
    }
    return targets;
}

void Gateway::connect_tunnel() {
    LinkSet carried;
    for (const std::string& name : settings_.tunnel->links) carried.insert(link_named(name).id());
    tunnel_->set_targets(wrap_targets());
    forwarder_.set_tunnel(tunnel_->id(), carried, *tunnel_);
}

void Gateway::pin_routes() {
    for (const RouteSettings& route : settings_.routes) forwarder_.pin(route.first, route.last, link_named(route.link).id());
    if (settings_.gateway.unknown == Unknown::link) forwarder_.set_unknown_link(link_named(settings_.gateway.unknown_link).id());
}

ControlLink* Gateway::control() {
    if (!control_ && links_.size() < max_links) {
        add_control();
        links_.back().since = now();
        control_->start();
    }
    return control_;
}

LinkId Gateway::add_control() {
    LinkSettings settings = ControlLink::link_settings(settings_);
    ForwarderLink link = forwarder_link(settings, 0, {});
    link.route.may_have_devices = false;    // its clients are programs
    const LinkId id = forwarder_.add_link(link);
    auto control = std::make_unique<ControlLink>(
        id, std::move(settings), LinkContext{io_, alarms_, *this, batch_, sender_, names_, v7_lines_}, forwarder_);
    control_ = control.get();
    add(std::move(control));
    return id;
}

void Gateway::add(std::unique_ptr<Link> link) {
    links_by_id_[index(link->id())] = link.get();
    links_.emplace_back().link = std::move(link);
}

LinkState& Gateway::state(const Link& link) {
    return *std::find_if(links_.begin(), links_.end(), [&](const LinkState& s) { return s.link.get() == &link; });
}

Link& Gateway::link_named(const std::string& name) const {
    for (const LinkState& s : links_)
        if (s.link->name() == name) return *s.link;
    throw std::logic_error("no link is called " + name);    // not possible with a checked configuration
}

void Gateway::start(RestartState stored) {
    stored_ = std::move(stored);
    started_at_ = turn().now();
    for (LinkState& s : links_) {
        s.since = started_at_;
        s.is_required = s.link->settings().required && s.link->settings().enabled;
    }
    gpio_->start();
    restore_brought();
    for (LinkState& s : links_) start(s);
    restore_addresses();
    stored_ = {};
    beat();    // opening the links may take long
    if (std::any_of(links_.begin(), links_.end(), [](const LinkState& s) { return s.is_required; }))
        required_check_.set(started_at_ + required_within);
}

void Gateway::start(LinkState& state) {
    if (state.link->settings().enabled) return state.link->start();
    state.error = LinkError{"disabled", "disabled (enabled=false)", {}};
    log_info("{}: disabled", state.link->name());
}

std::optional<StoredLink> Gateway::claim_stored(const Link& link) {
    for (RestartState::OfLink& stored : stored_.links)
        if (stored.name == link.name() && stored.link.wire) return std::move(stored.link);
    return std::nullopt;
}

// Skips a link whose name leads to a different device file, because its peers are others.
void Gateway::restore_addresses() {
    for (const RestartState::OfLink& stored : stored_.links)
        for (const LinkState& s : links_)
            if (s.link->name() == stored.name && wire_of(*s.link) == stored.wire) restore_addresses(*s.link, stored);
}

void Gateway::restore_addresses(const Link& link, const RestartState::OfLink& stored) {
    for (const ChannelId id : forwarder_.traffic(link.id()).channels)
        for (const StoredChannel& was : stored.channels) {
            if (was.peer != forwarder_.channel(id).peer) continue;
            for (const StoredAddress& heard : was.addresses)
                forwarder_.restore(heard.address, forwarder_.channel(id), heard.heard_at);
            for (const std::uint8_t address : was.first) forwarder_.restore_first(address, forwarder_.channel(id));
        }
}

// Independent of the device file: a copy may still be received on another link.
void Gateway::restore_brought() {
    for (const RestartState::OfLink& stored : stored_.links)
        for (const LinkState& s : links_)
            if (s.link->name() == stored.name)
                for (const DuplicateGuard::Memory& frame : stored.brought) forwarder_.restore(s.link->id(), frame);
}

void Gateway::check_required() {
    for (const LinkState& s : links_)
        if (s.is_required && !s.was_up && s.link->settings().enabled)
            return parts_.tell(&GatewayEvents::required_missing, s.link->name());
}

void Gateway::stop(Duration patience, std::function<void()> on_stopped) {
    if (on_stopped_) {
        if (stop_check_.is_set()) finish_stop();
        return;
    }
    on_stopped_ = std::move(on_stopped);
    parts_.tell(&GatewayEvents::stopping);
    required_check_.cancel();
    log_up_later_.cancel();
    change_check_.cancel();
    changing_.reset();
    beat_.cancel();
    for (LinkState& s : links_) s.link->stop_reading();
    names_.stop();
    turn();
    unread_since_ = beat_.loop().clocks();
    forwarder_.stop_asking();    // answers are not read any more
    flush();
    stop_by_ = now() + patience;
    stop_check_.set(now_ + stop_look);    // the kernel's counters include written bytes only a moment later
}

void Gateway::check_stop() {
    const bool all_left = std::all_of(links_.begin(), links_.end(), [this](const LinkState& s) { return nothing_waits(s); });
    if (all_left || now() >= stop_by_) finish_stop();
    else stop_check_.set(now_ + stop_look);
}

bool Gateway::nothing_waits(const LinkState& state) const {
    for (const ChannelId id : forwarder_.traffic(state.link->id()).channels)
        if (!forwarder_.channel(id).outbox.empty()) return false;
    const KernelQueue* const queue = state.link->as<KernelQueue>();
    return !state.up || !queue || queue->unsent() == 0;
}

void Gateway::finish_stop() {
    stop_check_.cancel();
    peer_log_.finish();
    beat_.finish();
    parts_.tell(&GatewayEvents::closing, unread_since_);
    for (LinkState& s : links_) s.link->stop();
    forwarder_due_.cancel();
    gpio_->stop();
    if (on_stopped_) std::exchange(on_stopped_, [] {})();
}

const StallDetector& Gateway::turn() {
    const ClockReading clocks = read_clocks();
    now_ = clocks.now;
    if (const Duration slept = beat_.turn(clocks); slept > Duration::zero()) forwarder_.grow_older(slept);
    return beat_.loop();
}

void Gateway::beat() {
    beat_.begin();
    turn();
    beat_.end(streams_are_active());
}

bool Gateway::streams_are_active() const {
    for (const ChannelId id : forwarder_.channels())
        if (streams_.contains(forwarder_.channel(id).link) && now_ - forwarder_.channel(id).arrived_at < StallWatch::calm_after)
            return true;
    return false;
}

Channel* Gateway::open_channel(Link& link, std::string peer) {
    const LinkKind& kind = *link.settings().kind;
    const bool has_many = kind.listens || kind.replays;    // no other channel is closed for such a link
    if (!has_many) make_channel_free_for_link();
    Channel* const channel = forwarder_.open_channel(link.id(), std::move(peer), now_);
    if (channel && !channel->peer.empty() && state(link).up) peer_log_.came(link.name(), channel->peer, now_);
    return channel;
}

void Gateway::close_channel(Channel& channel, std::string_view why) {
    const Link& link = *links_by_id_[index(channel.link)];
    if (state(link).up) peer_log_.went(link.name(), channel.peer, why, now_);
    parts_.tell(&GatewayEvents::channel_lost, channel.id);
    forwarder_.close_channel(channel);
}

void Gateway::receive(Channel& from, ano::FrameView frame) {
    beat_.heard(streams_.contains(from.link), std::min(from.arrived_at, now_));
    if (gpio_->watches(from.link)) gpio_->heard(from.link, now_);
    forwarder_.receive(from, frame, now_);
    if (parts_.own) parts_.own->send_waiting();
}

// Repeats until no channel is left, because flushing a link may report a failure, which may queue frames.
void Gateway::flush() {
    if (parts_.own) parts_.own->send_waiting();
    while (Channel* const channel = forwarder_.next_to_flush()) {
        if (gpio_->watches(channel->link)) gpio_->sends(channel->link, now_);
        links_by_id_[index(channel->link)]->flush(*channel);
    }
    while (const auto conflict = forwarder_.pop_conflict()) {
        const std::string what = conflict_text(*this, *conflict);
        log_warning("{}", what);
        parts_.tell(&GatewayEvents::conflict_began, what);
    }
    while (const auto moved = forwarder_.pop_move()) log_warning("{}", move_text(*this, *moved));
    await_forwarder();
}

void Gateway::await_forwarder() {
    if (const auto due = forwarder_.due()) forwarder_due_.set_no_later(*due);
    else forwarder_due_.cancel();
    if (const auto due = forwarder_.hello_due()) hello_due_.set_no_later(*due);
    else hello_due_.cancel();
}

void Gateway::changed(Link& link, LinkEvent event, LinkError why) {
    switch (event) {
    case LinkEvent::up: return came_up(link);
    case LinkEvent::down: return went_down(link, std::move(why));
    case LinkEvent::unreachable: return forwarder_.report_unreachable(link.id());
    case LinkEvent::trouble: return log_trouble(link, why);
    }
}

void Gateway::came_up(Link& link) {
    LinkState& s = state(link);
    forwarder_.link_up(link.id(), now_);
    const bool is_news = !std::exchange(s.up, true);
    if (link.settings().kind->replays) layouts_.set_replayed(replayed());
    if (!is_news) return;
    s.was_up = true;
    s.since = now_;
    gpio_->link_state(link.id(), true);
    await_forwarder();
    if (s.was_brief) log_up_later_.set_no_later(now_ + brief);
    else log_up(s);
    parts_.tell(&GatewayEvents::link_changed, s);
}

// Otherwise log_up() does it.
void Gateway::log_trouble(Link& link, const LinkError& trouble) {
    if (const LinkState& s = state(link); s.up && s.is_logged) log_warning("{}: {}", link.name(), trouble.text);
}

void Gateway::log_up(LinkState& s) {
    s.is_logged = true;
    log_info("{}: up", s.link->name());
    if (const LinkError trouble = s.link->trouble(); !trouble.text.empty()) log_warning("{}: {}", s.link->name(), trouble.text);
}

// A link that is lost again and again at once, as if its peer refuses it, is logged when it stays up.
void Gateway::log_up() {
    for (LinkState& s : links_) {
        if (!s.up || s.is_logged) continue;
        if (now_ - s.since >= brief) log_up(s);
        else log_up_later_.set_no_later(s.since + brief);
    }
}

void Gateway::lose_channels_of(LinkId link) {
    for (const ChannelId id : forwarder_.channels())
        if (forwarder_.channel(id).link == link) parts_.tell(&GatewayEvents::channel_lost, id);
}

void Gateway::went_down(Link& link, LinkError why) {
    LinkState& s = state(link);
    if (s.up) lose_channels_of(link.id());
    forwarder_.link_down(link.id());
    const bool is_news = s.up || s.error.text != why.text;
    if (s.is_logged || s.error.text != why.text) log_warning("{}: {}; waiting for it", link.name(), why.text);
    const bool was_up = s.up;
    if (was_up) s.was_brief = now_ - s.since < brief;
    if (was_up) s.since = now_;
    s.up = s.is_logged = false;
    s.error = std::move(why);
    if (is_news) parts_.tell(&GatewayEvents::link_changed, s);
    if (was_up) parts_.tell(&GatewayEvents::link_lost, s);
    gpio_->link_state(link.id(), false);
}

ChannelSet Gateway::busy_channels() const {
    ChannelSet busy;
    for (const ChannelId id : forwarder_.channels())
        if (forwarder_.channel(id).outbox.is_open() && forwarder_.channel(id).waiting() > 0) busy.insert(id);
    return busy;
}

bool Gateway::is_own_port(std::uint16_t port) const {
    return port != 0 && std::any_of(links_.begin(), links_.end(), [port](const LinkState& s) {
               const LocalPort* const bound = s.link->as<LocalPort>();
               return bound && bound->local_port() == port;
           });
}

}    // namespace anogate
