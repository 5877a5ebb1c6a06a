#include <ano/address.hpp>
#include <gateway/router.hpp>

#include <algorithm>
#include <cassert>

namespace anogate {

namespace address = ano::address;

std::string_view text(Via via) noexcept {
    switch (via) {
    case Via::nobody: return "nobody";
    case Via::own: return "own";
    case Via::broadcast: return "broadcast";
    case Via::port: return "port";
    case Via::pinned: return "pinned";
    case Via::learned: return "learned";
    case Via::unknown: return "unknown";
    }
    return "";
}

Router::Router(const GatewaySettings& settings) { set(settings); }

void Router::set(const GatewaySettings& settings) {
    forget_after_ = settings.forget_after;
    own_id_ = settings.id;
    unknown_ = settings.unknown;
    unknown_links_.clear();
}

LinkId Router::add_link(const LinkRule& rule) {
    assert(used_.size() < max_links && rule.port_id <= address::last_port_id && rule.group <= max_links);
    const LinkId id = *(~used_).begin();
    used_.insert(id);
    links_[index(id)] = rule;
    if (address::is_port_id(rule.port_id)) ports_[rule.port_id].insert(id);
    if (rule.group != 0) {
        groups_[rule.group].insert(id);
        grouped_ = true;
    }
    return id;
}

void Router::remove_link(LinkId link) {
    assert(used_.contains(link) && channels_of_link_[index(link)].empty());
    used_.erase(link);
    links_[index(link)] = {};
    heard_link_[index(link)] = TimePoint::min();
    unknown_links_.erase(link);
    remade_.erase(link);
    for (LinkSet& left : left_) left.erase(link);
    for (LinkSet& from : moved_from_) from.erase(link);
    for (LinkSet& port : ports_) port.erase(link);
    for (LinkSet& pinned : pinned_) pinned.erase(link);
    for (LinkSet& group : groups_) group.erase(link);
    grouped_ = std::any_of(groups_.begin(), groups_.end(), [](LinkSet group) { return !group.empty(); });
    for (Conflict& c : conflicts_) {
        if (!c.links.contains(link)) continue;
        c.links.erase(link);
        if (!c.links.has_several()) forget_conflict(c.address);
    }
}

void Router::forget_conflict(std::uint8_t address) {
    conflicts_[address] = {};
    new_conflicts_.reset(address);
    new_claimants_.reset(address);
    has_unreported_ = new_conflicts_.any() || new_claimants_.any();
}

void Router::pin(std::uint8_t first, std::uint8_t last, LinkId link) {
    for (unsigned a = first; a <= last; ++a) {
        pinned_[a].insert(link);
        claims_.end(static_cast<std::uint8_t>(a));    // the claimant may be on another link
    }
}

void Router::unpin(std::uint8_t first, std::uint8_t last, LinkId link) {
    for (unsigned a = first; a <= last; ++a) pinned_[a].erase(link);
}

void Router::open(ChannelId channel, LinkId link) {
    ++open_;
    link_of_[index(channel)] = link;
    commanded_at_[index(channel)] = {};
    channels_of_link_[index(link)].insert(channel);
    homes_changed_ = true;
    if (links_[index(link)].flood) flooded_.insert(channel);
    if (links_[index(link)].broadcast) broadcast_.insert(channel);
}

void Router::leave_group(ChannelId channel) { apart_.insert(channel); }

void Router::close(ChannelId channel) {
    --open_;
    channels_of_link_[index(link_of_[index(channel)])].erase(channel);
    flooded_.erase(channel);
    broadcast_.erase(channel);
    down_.erase(channel);
    hosts_.erase(channel);
    apart_.erase(channel);
    for (ChannelSet& also : also_) also.erase(channel);
    homes_changed_ = true;
    for (ChannelSet& port : port_channels_) port.erase(channel);
    for (unsigned a = 0; a < known_.size(); ++a) {
        if (known_[a] == ChannelSet{channel}) left_[a] = link_of_[index(channel)];
        known_[a].erase(channel);
    }
    for (ChannelSet& first : first_) first.erase(channel);
    if (!claims_.next()) return;
    for (unsigned a = 0; a < known_.size(); ++a)
        if (const auto address = static_cast<std::uint8_t>(a);
            claims_.is_under_way(address) && claims_.claimant(address) == channel)
            claims_.end(address);
    settle();
}

void Router::went_down(ChannelId channel) {
    down_.insert(channel);
    if (claims_.next()) settle();
}

bool Router::has_newer_command_of_mate(ChannelId channel, TimePoint since) const noexcept {
    for (const ChannelId mate : mates(channel) - down_)
        if (commanded_at_[index(mate)] > since) return true;
    return false;
}

// Ends the tests of addresses whose holder has no connected channel: the address moves to the claimant.
void Router::settle() {
    for (unsigned a = 0; a < known_.size(); ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        if (!claims_.is_under_way(address)) continue;
        const ChannelId claimant = claims_.claimant(address);
        if (!(rivals(address, claimant) - down_).empty()) continue;
        move(address, claimant);
        claims_.end(address);
    }
}

// The first home is stored: a frame of the device received there moves the address back.
void Router::move(std::uint8_t source, ChannelId to) {
    note_move(source, to);
    ChannelSet& first = first_[source];
    const ChannelSet left = rivals(source, to);
    if (was_first(source, to)) first -= bounds(source, to) | mates(to);
    else if ((first & bounds(source, to)).empty()) first |= left;
    known_[source] = (known_[source] - left) | to;
    homes_changed_ = true;
}

void Router::note_move(std::uint8_t source, ChannelId to) noexcept {
    const LinkId link = link_of_[index(to)];
    const LinkSet last = known_[source].empty() ? left_[source] : links_of(known_[source]);
    const LinkSet from = last.empty() ? pinned_[source] : last;
    if (from.empty() || from.contains(link)) return;
    LinkSet& before = moved_from_[source];
    if (before.contains(link)) before.clear();
    else if (before.empty()) before = from;
    new_moves_.set(source);
    left_[source] = from;
}

std::optional<Router::Moved> Router::pop_move() noexcept {
    if (new_moves_.none()) return std::nullopt;
    std::size_t a = 0;
    while (!new_moves_[a]) ++a;
    new_moves_.reset(a);
    const auto address = static_cast<std::uint8_t>(a);
    const LinkSet now = links_of(known_[address]);
    return now.empty() ? std::nullopt : std::optional{Moved{address, left_[address], *now.begin()}};
}

bool Router::was_first(std::uint8_t source, ChannelId channel) const noexcept {
    return !(first_[source] & (mates(channel) | channel)).empty();
}

Route Router::route(ChannelId from, std::uint8_t source, std::uint8_t destination, TimePoint now, ano::Intent intent) {
    learn(from, source, now);
    return spread(from, source, destination, now, intent);
}

Route Router::spread(ChannelId from, std::uint8_t source, std::uint8_t destination, TimePoint now, ano::Intent intent) {
    Route route;
    route.new_conflict = has_unreported_;
    decide(route, destination, intent, now);
    route.channels.erase(from);
    if (source == destination && route.channels.empty() && route.absent.empty()) to_namesakes(route, source, from, intent);
    if (grouped_) {
        if (!apart_.contains(from)) heard_link_[index(link_of_[index(from)])] = now;
        keep_one_of_each_group(route, link_of_[index(from)], group_of(from), destination, intent, now);
    }
    guard(route, destination);
    return route;
}

Route Router::find(LinkId from, std::uint8_t destination, TimePoint now, ano::Intent intent) {
    Route route;
    decide(route, destination, intent, now);
    if (grouped_) keep_one_of_each_group(route, from, links_[index(from)].group, destination, intent, now);
    guard(route, destination);
    return route;
}

// A frame to a host is guarded too. Hosts may be on several sides of a loop and never expire, so each gateway may have learned
// another path to them.
void Router::guard(Route& route, std::uint8_t destination) const noexcept {
    const bool spread = route.via == Via::broadcast || route.via == Via::unknown || route.channels.has_several() ||
                        (address::is_host(destination) && open_ > 2);
    route.guarded = spread ? route.guarded | route.channels : ChannelSet{};
}

// Decides the channels of the frame; the one on which it was received may be among them.
void Router::decide(Route& route, std::uint8_t destination, ano::Intent intent, TimePoint now) {
    if (destination == address::broadcast) {
        route.via = Via::broadcast;
        route.channels = broadcast_;
    } else if (destination == address::unassigned) {
        return;
    } else if (destination == own_id_) {
        route.via = Via::own;
        ++own_frames_;
    } else if (is_port(destination)) {
        route.via = Via::port;
        to_links(route, ports_[destination]);
        route.channels |= port_channels_[destination];
    } else if (!pinned_[destination].empty()) {
        route.via = Via::pinned;
        to_pinned(route, destination);
    } else if (const ChannelSet heard = heard_from(destination, now); !heard.empty()) {
        route.via = Via::learned;
        route.channels = heard;
        route.host_is_down = address::is_host(destination) && is_cut_off(heard);
        if (route.host_is_down) add_unknown(route, destination, intent);    // the host may use another link now
    } else if (intent != ano::Intent::acts || !to_last_home(route, destination)) {
        add_unknown(route, destination, intent);
    }
}

// A host and a device have the same address. The frame was received where that address is at home, so it is for the other one.
void Router::to_namesakes(Route& route, std::uint8_t address, ChannelId from, ano::Intent intent) {
    if (route.via != Via::learned && route.via != Via::pinned) return;
    route.channels = (known_[address] | also_[address] | first_[address]) - from;
    if (!route.channels.empty()) return;
    add_unknown(route, address, intent);
    route.channels.erase(from);
}

// A frame that acts on a device goes to the last place of the device, at any age. False: the device was never received.
bool Router::to_last_home(Route& route, std::uint8_t destination) {
    const ChannelSet known = known_[destination];
    if (known.empty() && left_[destination].empty()) return false;
    route.via = Via::learned;
    if (known.empty()) {
        to_links(route, left_[destination]);
        const ChannelSet of_others = places_of_devices_alone();
        route.channels -= of_others - silent_;
        return true;
    }
    ChannelId last = *known.begin();
    for (const ChannelId channel : known)
        if (heard(destination, channel) > heard(destination, last)) last = channel;
    route.channels = last;
    return true;
}

// Adds the channels for frames to addresses that were never received. Some devices act on each frame, whatever its address. So a
// flooded frame that acts is not sent to places with only other devices, unless there is only one such place.
void Router::add_unknown(Route& route, std::uint8_t destination, ano::Intent intent) {
    if (unknown_ == Unknown::drop) return;
    route.via = Via::unknown;
    if (unknown_ == Unknown::link) return to_links(route, unknown_links_);
    ChannelSet flooded = flooded_;
    if (address::is_host(destination)) flooded -= places_of_devices_alone();
    else if (intent == ano::Intent::acts) flooded -= places_of_devices_alone() - the_only_place(places_of(devices()));
    route.channels |= flooded;
}

// Returns `devices` if all of them are in one place, its devices act only on frames for their own address, and an unknown address
// can't be anywhere else.
ChannelSet Router::the_only_place(ChannelSet devices) const noexcept {
    const LinkSet links = links_of(devices);
    if (links.empty()) return {};
    const LinkRule& rule = links_[index(*links.begin())];
    if (devices.has_several() && !(devices - members(rule.group)).empty()) return {};
    for (const LinkId link : links)
        if (links_[index(link)].acts_for_others) return {};
    for (const LinkId link : used_ - links) {
        const LinkRule& other = links_[index(link)];
        const bool is_elsewhere = other.group == 0 || other.group != rule.group;
        if (other.may_have_devices && other.flood && is_elsewhere && is_unheard(link)) return {};
    }
    return devices;
}

// The channels where a device is at home, and those of restored links with devices on which nothing was received since.
ChannelSet Router::devices() {
    if (homes_changed_) {
        ChannelSet heard, silent;
        devices_.clear();
        for (unsigned a = 0; a < known_.size(); ++a) {
            heard |= known_[a];
            if (address::is_host(static_cast<std::uint8_t>(a))) continue;
            devices_ |= known_[a];
            if (known_[a].empty()) silent |= channels_of(left_[a] & remade_);
        }
        silent_ = silent - heard;
        heard_any_ = heard;
        devices_ |= silent_;
        homes_changed_ = false;
    }
    return devices_;
}

std::bitset<256> Router::last_homes(LinkId link) const noexcept {
    std::bitset<256> addresses;
    for (unsigned a = 0; a < known_.size(); ++a)
        addresses[a] = known_[a].empty() ? left_[a].contains(link) : links_of(known_[a]) == LinkSet{link};
    return addresses;
}

void Router::restore_last_homes(const std::bitset<256>& addresses, LinkId link) noexcept {
    for (unsigned a = 0; a < known_.size(); ++a)
        if (addresses[a] && known_[a].empty()) left_[a].insert(link);
    remade_.insert(link);
    homes_changed_ = true;
}

bool Router::is_alone(std::uint8_t source, ChannelId channel) const noexcept {
    if (hosts_.contains(channel)) return false;
    for (unsigned a = 0; a < known_.size(); ++a)
        if (a != source && known_[a].contains(channel)) return false;
    return known_[source].contains(channel);
}

// Adds all channels of the same groups.
ChannelSet Router::places_of(ChannelSet channels) const noexcept {
    if (!grouped_) return channels;
    ChannelSet places = channels;
    for (const ChannelId channel : channels) places |= mates(channel);
    return places;
}

Router::Learned Router::learned(std::uint8_t a, TimePoint now) const {
    Learned result;
    for (const ChannelId channel : known_[a]) {
        const TimePoint at = heard_[a][index(channel)];
        if (!address::is_host(a) && now - at >= forget_after_) continue;
        result.links.insert(link_of_[index(channel)]);
        result.last = std::max(result.last, at);
    }
    return result;
}

std::vector<Conflict> Router::conflicts(TimePoint now) const {
    std::vector<Conflict> result;
    for (const Conflict& c : conflicts_)
        if (c.count > 0 && now - c.last < forget_after_) result.push_back(c);
    return result;
}

std::optional<std::uint8_t> Router::pop_first(std::bitset<256>& unreported) {
    if (unreported.none()) return std::nullopt;
    std::size_t a = 0;
    while (!unreported[a]) ++a;
    unreported.reset(a);
    has_unreported_ = new_conflicts_.any() || new_claimants_.any();
    return static_cast<std::uint8_t>(a);
}

bool Router::pop_new_conflict(Conflict& conflict) {
    const auto address = pop_first(new_conflicts_);
    if (address) conflict = conflicts_[*address];
    return address.has_value();
}

bool Router::pop_claimant(Claimant& claimant) {
    const auto address = pop_first(new_claimants_);
    if (address) claimant = {*address, claimants_[*address]};
    return address.has_value();
}

bool Router::forget(std::uint8_t address) {
    const bool was_known = !known_[address].empty();
    known_[address].clear();
    left_[address].clear();
    also_[address].clear();
    homes_changed_ = true;
    first_[address].clear();
    moved_from_[address].clear();
    new_moves_.reset(address);
    claims_.end(address);
    forget_conflict(address);
    return was_known;
}

void Router::learn(ChannelId from, std::uint8_t source, TimePoint now) {
    ChannelSet& known = known_[source];
    if (!known.contains(from)) {
        if (!links_[index(link_of_[index(from)])].teaches) return;
        if (source == address::unassigned || source == address::broadcast) return;
        if (claims(source, from)) return claim(source, from, now);
        const bool has_homes = !known.empty() || !pinned_[source].empty();
        const bool adds_home = has_homes && rivals(source, from).empty();
        homes_changed_ = true;
        if (address::is_host(source) || adds_home) known.insert(from);
        else come_back(source, from, now);
    }
    heard(source, from) = now;
    if (claims_.is_under_way(source) && rivals(source, claims_.claimant(source)).contains(from)) refuse(source, now);
}

std::optional<TimePoint> Router::heard_at(std::uint8_t address, ChannelId channel) const noexcept {
    return known_[address].contains(channel) ? std::optional{heard(address, channel)} : std::nullopt;
}

void Router::restore(std::uint8_t source, ChannelId channel, TimePoint at) {
    if (source == address::unassigned || source == address::broadcast) return;
    known_[source].insert(channel);
    homes_changed_ = true;
    heard(source, channel) = at;
    if (apart_.contains(channel)) return;
    TimePoint& heard_link = heard_link_[index(link_of_[index(channel)])];
    heard_link = std::max(heard_link, at);
}

// The source is received again where it was first, or where no other channel is up. If it was also received on another channel
// just now, that is a conflict.
void Router::come_back(std::uint8_t source, ChannelId from, TimePoint now) {
    std::optional<ChannelId> other;
    for (const ChannelId channel : rivals(source, from) - down_)
        if (now - heard(source, channel) < moved_after && (!other || heard(source, channel) > heard(source, *other)))
            other = channel;
    move(source, from);
    if (other) note_conflict(source, LinkSet{link_of_[index(from)]} | link_of_[index(*other)], other, now);
}

bool Router::heard_again(ChannelId from, std::uint8_t source, TimePoint now) {
    if (!known_[source].contains(from) && !first_[source].contains(from)) return false;
    learn(from, source, now);
    return has_unreported_;
}

bool Router::holds(std::uint8_t source, ChannelId channel) const noexcept {
    const LinkSet pinned = pinned_[source];
    if (pinned.empty()) return known_[source].contains(channel);
    return pinned.contains(link_of_[index(channel)]) && !claims(source, channel);
}

bool Router::claims(std::uint8_t source, ChannelId channel) const noexcept {
    if (address::is_host(source) || source == address::unassigned || source == address::broadcast) return false;
    if (!links_[index(link_of_[index(channel)])].teaches) return false;
    if (is_outside(source, channel)) return true;
    if (known_[source].contains(channel)) return false;
    return !(rivals(source, channel) - down_).empty() && !was_first(source, channel);
}

bool Router::is_outside(std::uint8_t source, ChannelId channel) const noexcept {
    const LinkSet pinned = pinned_[source];
    const LinkId link = link_of_[index(channel)];
    if (pinned.empty() || pinned.contains(link)) return false;
    return (pinned & links_beside(link)).empty() || apart_.contains(channel);
}

ChannelSet Router::rivals(std::uint8_t source, ChannelId channel) const noexcept {
    return known_[source] & bounds(source, channel);
}

// A device has one home, in a group one on each link. A pinned device has one on each of its links, and one on each other link of
// their groups.
ChannelSet Router::bounds(std::uint8_t source, ChannelId channel) const noexcept {
    const LinkSet pinned = pinned_[source];
    if (pinned.empty()) return ~mates(channel);
    const LinkId link = link_of_[index(channel)];
    return channels_of((links_beside(link) - pinned) | link) - mates(channel);
}

// A claim of a pinned address on another link is refused without a question. It does not delay a claim on its own link.
void Router::claim(std::uint8_t source, ChannelId from, TimePoint now) {
    also_[source].insert(from);
    if (is_outside(source, from)) {
        if (now < next_refusal_[source]) return keep_conflict(source, now);
        next_refusal_[source] = now + Claims::Pace{}.between_tests;
        return note_conflict(source, pinned_[source] | link_of_[index(from)], from, now);
    }
    if (!claims_.is_under_way(source) || claims_.claimant(source) == from) heard(source, from) = now;
    if (!claims_.begin(source, from, now)) keep_conflict(source, now);
}

void Router::keep_conflict(std::uint8_t source, TimePoint now) noexcept {
    Conflict& c = conflicts_[source];
    if (c.count > 0 && now - c.last < forget_after_) c.last = now;
}

void Router::refuse(std::uint8_t source, TimePoint now) {
    const ChannelId claimant = claims_.claimant(source);
    claims_.end(source);
    note_conflict(source, links_of(rivals(source, claimant)) | link_of_[index(claimant)], claimant, now);
}

std::optional<Router::Question> Router::pop_question(TimePoint now) {
    while (const auto due = claims_.next_due(now)) {
        if (!due->silent) return Question{due->address, rivals(due->address, due->claimant) - down_};
        move(due->address, due->claimant);
    }
    return std::nullopt;
}

void Router::note_conflict(std::uint8_t source, LinkSet links, std::optional<ChannelId> claimant, TimePoint now) {
    Conflict& c = conflicts_[source];
    const bool over = c.count > 0 && now - c.last >= forget_after_;
    if (c.count == 0 || over) {
        c.links.clear();
        c.claimed = false;
        new_conflicts_.set(source);
        has_unreported_ = true;
    }
    if (claimant) {
        claimants_[source] = *claimant;
        new_claimants_.set(source);
        has_unreported_ = true;
        c.claimed = true;
    }
    c.address = source;
    c.links |= links;
    c.last = now;
    ++c.count;
}

// The channels for frames to `a`: those on which it was received lately, else those where its route has not expired.
ChannelSet Router::heard_from(std::uint8_t a, TimePoint now) const {
    const ChannelSet known = known_[a];
    if (address::is_host(a)) return known;
    ChannelSet lately, remembered;
    for (const ChannelId channel : known) {
        const Duration age = now - heard(a, channel);
        if (age < forget_after_) remembered.insert(channel);
        if (age < std::min(moved_after, forget_after_)) lately.insert(channel);
    }
    return lately.empty() ? remembered : lately;
}

// Whether no connected wire leads to any of these places.
bool Router::is_cut_off(ChannelSet known) const noexcept {
    if (!are_all_down(known)) return false;
    for (const ChannelId channel : known)
        if (!are_all_down(mates(channel))) return false;
    return true;
}

LinkSet Router::links_of(ChannelSet channels) const noexcept {
    LinkSet links;
    for (const ChannelId channel : channels) links.insert(link_of_[index(channel)]);
    return links;
}

ChannelSet Router::channels_of(LinkSet links) const noexcept {
    ChannelSet channels;
    for (const LinkId link : links) channels |= channels_of_link_[index(link)];
    return channels;
}

void Router::to_links(Route& route, LinkSet links) const {
    route.channels |= channels_of(links);
    for (const LinkId link : links)
        if (channels_of_link_[index(link)].empty()) route.absent.insert(link);
}

void Router::to_pinned(Route& route, std::uint8_t destination) const {
    to_links(route, pinned_[destination]);
    if (address::is_host(destination)) return;
    const ChannelSet homes = known_[destination] - down_;
    keep_homes(route.channels, pinned_[destination], homes);
}

// Keeps for each link the channels where the device is at home, else all.
void Router::keep_homes(ChannelSet& channels, LinkSet links, ChannelSet homes) const noexcept {
    for (const LinkId link : links)
        if (const ChannelSet all = channels_of_link_[index(link)]; !(channels & all & homes).empty()) channels -= all - homes;
}

// The other links of the group of `link`.
LinkSet Router::links_beside(LinkId link) const noexcept { return groups_[links_[index(link)].group] - link; }

// The members of the group of `channel` on other links: they lead to the same place. The peers of one link are independent.
ChannelSet Router::mates(ChannelId channel) const noexcept {
    return members(group_of(channel)) - channels_of_link_[index(link_of_[index(channel)])];
}

// A frame is sent to a group on one of its links. It is sent to the group it was received from only on the same link (to its
// other peers). A port id always means that port.
void Router::keep_one_of_each_group(Route& route, LinkId from, std::uint8_t its_group, std::uint8_t destination,
                                    ano::Intent intent, TimePoint now) const {
    if (route.via == Via::port) return;
    if (its_group != 0) {
        route.channels -= members(its_group) - channels_of_link_[index(from)];
        route.absent -= links_beside(from);
    }
    const bool has_homes = destination != address::broadcast && !address::is_host(destination);
    const ChannelSet homes = has_homes ? known_[destination] - down_ : ChannelSet{};
    const ChannelSet willing = route.via == Via::broadcast                               ? broadcast_
                               : route.via == Via::unknown && unknown_ == Unknown::flood ? flooded_
                                                                                         : ~ChannelSet{};
    for (std::uint8_t number = 1; number <= max_links; ++number) {
        const LinkSet group = groups_[number];
        if (group.empty() || number == its_group) continue;
        const ChannelSet all = members(number);
        if ((route.channels & all).empty() && (route.absent & group).empty()) continue;
        const LinkSet best = best_of(group, all & willing, intent, now);
        ChannelSet chosen = channels_of(best) & all & willing;
        keep_homes(chosen, best, homes);
        route.channels = (route.channels - all) | chosen;
        route.guarded |= all;
        if (!chosen.empty()) route.absent -= group;
    }
}

// The link of a group on which a frame was received last, and which is up. If none was received lately, all links that are up,
// except for a frame that acts on devices that would execute it once for each link.
LinkSet Router::best_of(LinkSet group, ChannelSet able, ano::Intent intent, TimePoint now) const {
    if (const ChannelSet up = able - down_; !up.empty()) able = up;
    LinkSet links;
    LinkId best{};
    TimePoint heard = TimePoint::min();
    bool is_for_one = false;
    for (const LinkId link : group) {
        if ((channels_of_link_[index(link)] & able).empty()) continue;
        if (links.empty() || heard_link_[index(link)] > heard) {
            best = link;
            heard = heard_link_[index(link)];
        }
        links.insert(link);
        is_for_one = is_for_one || (intent == ano::Intent::acts && !links_[index(link)].drops_copies);
    }
    return is_for_one || heard + group_silence > now ? LinkSet{best} : links;
}

}    // namespace anogate
