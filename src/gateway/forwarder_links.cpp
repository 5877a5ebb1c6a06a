// The part of the Forwarder that adds and removes links and channels.
#include <gateway/forwarder.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

std::size_t largest_data(const ForwarderLink& settings) {
    return ano::max_image_data_at(std::max(settings.parser.max_data, settings.outbox.max_data));
}

}    // namespace

LinkId Forwarder::add_link(const ForwarderLink& settings) {
    const LinkId id = router_.add_link(settings.route);
    added_.insert(id);
    ++version_;
    links_[index(id)] = std::make_unique<LinkEntry>();
    LinkEntry& link = entry(id);
    link.settings = settings;
    link.traffic.attitudes = AttitudeWatch{settings.attitude};
    if (settings.rules != RuleSettings{} || !settings.sends_empty)
        link.rules = std::make_unique<Rules>(settings.rules, settings.sends_empty);
    if (settings.hello != Duration{} && (settings.route.broadcast || settings.route.acts_for_others))
        link.hello.emplace(settings.hello);
    if (!settings.aliases.empty()) {
        const std::size_t max_data = largest_data(settings);
        link.aliases = std::make_unique<Aliases>(settings.aliases, max_data);
        for (const AliasRule& rule : settings.aliases) router_.pin(rule.as, rule.as, id);    // the alias exists only here
    }
    if (settings.present_as != 0) present(link);
    if (link.has_rules()) ruled_.insert(id);
    return id;
}

// The links of a group share one PresentAs: the answer to a question may be received on another link of the group.
void Forwarder::present(LinkEntry& link) {
    const ForwarderLink& settings = link.settings;
    const std::size_t max_data = largest_data(settings);
    for (const LinkId other : added_)
        if (settings.route.group != 0 && entry(other).settings.route.group == settings.route.group && entry(other).present_as)
            link.present_as = entry(other).present_as;
    if (!link.present_as)
        link.present_as = presentations_.emplace_back(std::make_unique<PresentAs>(settings.present_as, max_data)).get();
    link.present_as->make_room(max_data);
    if (settings.route.port_id != 0) link.present_as->add_port(settings.route.port_id);
}

void Forwarder::forget_presentation(LinkEntry& link) {
    PresentAs* const forgotten = std::exchange(link.present_as, nullptr);
    if (!forgotten) return;
    bool is_used = false;
    forgotten->remove_port(link.settings.route.port_id);
    for (const LinkId other : added_) {
        if (entry(other).present_as != forgotten) continue;
        is_used = true;
        if (entry(other).settings.route.port_id != 0) forgotten->add_port(entry(other).settings.route.port_id);
    }
    if (!is_used) std::erase_if(presentations_, [forgotten](const auto& one) { return one.get() == forgotten; });
}

void Forwarder::set_exclusive(LinkId id, bool exclusive) {
    LinkEntry& link = entry(id);
    link.exclusive = exclusive;
    if (exclusive || link.has_rules()) ruled_.insert(id);
    else ruled_.erase(id);
    if (!exclusive) return;
    for (const ChannelId channel : link.traffic.channels) {
        channels_[index(channel)]->outbox.drop_waiting(&SendCounters::denied_out);
        if (auto& questions = channels_[index(channel)]->questions) questions->drop_waiting(&SendCounters::denied_out);
    }
}

bool Forwarder::is_exclusive(LinkId link) const noexcept { return entry(link).exclusive; }

void Forwarder::remove_link(LinkId id) {
    LinkEntry& link = entry(id);
    const std::uint8_t group = link.settings.route.group;
    for (const ChannelId channel : link.traffic.channels) close_channel(*channels_[index(channel)]);
    if (tunnel_ && tunnel_link_ == id) {
        tunnel_ = nullptr;
        carried_.clear();
    }
    forget_presentation(link);
    carried_.erase(id);
    ruled_.erase(id);
    added_.erase(id);
    ++version_;
    links_[index(id)].reset();
    router_.remove_link(id);
    duplicates_.remove_link(id);
    if (group != 0 && router_.group(group).empty()) duplicates_.remove_group(group);
    same_device_.remove_link(id);
    inhibit_.remove_link(id);
    std::erase_if(claimants_, [id](const auto& claimant) { return claimant.second.link == id; });
    for (Observer* observer : observers_) observer->removed(id);
}

void Forwarder::restore(LinkId link, const DuplicateGuard::Memory& brought) {
    if (const std::uint8_t group = entry(link).settings.route.group; group != 0) duplicates_.restore(brought, group, link);
}

void Forwarder::unpin(std::uint8_t first, std::uint8_t last, LinkId link) {
    router_.unpin(first, last, link);
    for (const AliasRule& rule : entry(link).settings.aliases) router_.pin(rule.as, rule.as, link);
}

void Forwarder::set_tunnel(LinkId link, LinkSet carried, TunnelPort& port) {
    tunnel_link_ = link;
    carried_ = carried;
    tunnel_ = &port;
}

Channel* Forwarder::open_channel(LinkId id, std::string peer, TimePoint now) {
    const ChannelSet unused = ~used_;
    if (unused.empty()) return nullptr;
    const ChannelId channel = *unused.begin();
    LinkEntry& link = entry(id);
    const ForwarderLink& settings = link.settings;
    auto& opened = channels_[index(channel)];
    opened = std::make_unique<Channel>(channel, id, std::move(peer), settings.parser, settings.outbox, now);
    if (settings.limits_questions)
        opened->questions = std::make_unique<QuestionQueue>(
            opened->outbox, QuestionQueue::Options{settings.outbox.bytes, settings.outbox.age.rest});
    used_.insert(channel);
    ++version_;
    if (!departure_observers_.empty()) opened->outbox.watch(this, channel);
    link.traffic.channels.insert(channel);
    router_.open(channel, id);
    loop_guard_.open(channel, id, settings.route.group, settings.allows_probes, now);
    return opened.get();
}

void Forwarder::leave_group(Channel& channel) {
    router_.leave_group(channel.id);
    loop_guard_.open(channel.id, channel.link, 0, entry(channel.link).settings.allows_probes, channel.opened_at);
}

void Forwarder::close_channel(Channel& channel) {
    LinkTraffic& traffic = entry(channel.link).traffic;
    loop_guard_.close(channel.id);
    channel.outbox.close();
    if (channel.questions) channel.questions->close();
    ++version_;
    add(traffic.gone_received, channel.received());
    add(traffic.gone_sent, channel.sent());
    traffic.channels.erase(channel.id);
    used_.erase(channel.id);
    to_flush_.erase(channel.id);
    router_.close(channel.id);
    channels_[index(channel.id)].reset();
}

void Forwarder::link_up(LinkId id, TimePoint now) {
    LinkEntry& link = entry(id);
    for (const ChannelId channel : link.traffic.channels) {
        channels_[index(channel)]->outbox.open();
        router_.came_up(channel);
    }
    if (std::exchange(link.up, true)) return;
    if (link.hello) link.hello->came_up(now);
    await_hellos();
}

void Forwarder::link_down(LinkId id) {
    LinkEntry& link = entry(id);
    for (const ChannelId channel : link.traffic.channels) {
        channels_[index(channel)]->outbox.close();
        if (auto& questions = channels_[index(channel)]->questions) questions->close();
        router_.went_down(channel);
    }
    link.up = false;
    if (link.hello) link.hello->went_down();
}

void Forwarder::add_observer(Observer& observer, Observer::Wants wants) {
    const auto put = [&observer](std::vector<Observer*>& all, bool is_wanted) {
        const auto place = std::find(all.begin(), all.end(), &observer);
        if (!is_wanted && place != all.end()) all.erase(place);
        else if (is_wanted && place == all.end()) all.push_back(&observer);
    };
    put(observers_, true);
    put(arrival_observers_, wants.arrivals);
    put(fate_observers_, wants.fates);
    put(departure_observers_, wants.departures);
    put(always_, wants.always);
    watch_outboxes();
}

void Forwarder::remove_observer(Observer& observer) {
    add_observer(observer, {false, false, false, false});
    std::erase(observers_, &observer);
}

void Forwarder::watch_outboxes() noexcept {
    for (const ChannelId id : used_) channels_[index(id)]->outbox.watch(departure_observers_.empty() ? nullptr : this, id);
}

void Forwarder::left(ChannelId channel, ano::FrameView frame) noexcept {
    for (Observer* observer : departure_observers_) observer->left(*channels_[index(channel)], frame);
}

void Forwarder::dropped(ChannelId channel, ano::FrameView frame, SendCause cause) noexcept {
    for (Observer* observer : departure_observers_) observer->discarded(*channels_[index(channel)], frame, cause);
}

void Forwarder::grow_older(Duration time) {
    for (const ChannelId id : used_) {
        channels_[index(id)]->outbox.grow_older(time);
        if (auto& questions = channels_[index(id)]->questions) questions->grow_older(time);
    }
}

void Forwarder::stop_asking() {
    asks_ = false;
    questions_due_ = TimePoint::max();
    hello_due_.reset();
    for (const ChannelId id : used_)
        if (auto& questions = channels_[index(id)]->questions) questions->close();
}

}    // namespace anogate
