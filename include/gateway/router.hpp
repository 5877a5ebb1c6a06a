// Decides to which channels a frame is sent. No I/O and no clock (protocol text, section 2; config/README.md, "Where frames go").
#pragma once
#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <ano/time.hpp>
#include <gateway/claims.hpp>
#include <gateway/ids.hpp>
#include <gateway/settings.hpp>

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace anogate {

/// Which rule decided.
enum class Via : std::uint8_t { nobody, own, broadcast, port, pinned, learned, unknown };
std::string_view text(Via via) noexcept;

/// Where one frame goes: to all `channels`. `absent` are the links of the route that have no channel now.
struct Route {
    ChannelSet channels;
    LinkSet absent;
    Via via = Via::nobody;
    bool new_conflict = false;    // Router::pop_claimant() and pop_new_conflict() return news
    bool host_is_down = false;    // the destination is a host, received only on channels whose wire is disconnected
    /// The channels on which the frame may return, for the loop guard. Empty for a frame with only one receiver, unless its
    /// destination is a host.
    ChannelSet guarded{};
};

/// A source is received in two places: two devices with one id, one device by two paths, or a forged address.
struct Conflict {
    std::uint8_t address = 0;
    LinkSet links;
    bool claimed = false;    // Router::pop_claimant() returns the claimant
    TimePoint last{};
    std::uint64_t count = 0;    // how often it was detected: refused claims, and equal frames on two links
};

/// Constant time per frame; no allocation after the links are known.
class Router {
public:
    struct LinkRule {
        std::uint8_t port_id = 0;    // 0: none
        bool flood = true;
        bool broadcast = true;
        std::uint8_t group = 0;           // 1 to 64: links with the same number lead to the same place; 0: none
        bool teaches = true;              // sources of its frames are learned. False: a replay
        bool acts_for_others = false;     // its devices act on frames for any address
        bool may_have_devices = false;    // even if nothing was received on it: it does not wait for hosts
        bool drops_copies = true;         // its devices recognise a frame that they receive a second time by another link
    };

    /// If a device was received on several channels, the ones on which it was received within this time get its frames.
    static constexpr Duration moved_after = std::chrono::seconds{3};
    /// If nothing was received on any link of a group for this time, no link is known to work: frames go to all of them.
    static constexpr Duration group_silence = std::chrono::seconds{1};

    explicit Router(const GatewaySettings& settings);
    /// Changes the settings. set_unknown_link() must be called again.
    void set(const GatewaySettings& settings);

    /// Returns the lowest free number; one must be free.
    LinkId add_link(const LinkRule& rule);
    /// A device there answered for another address: treat the link as if its rule had acts_for_others.
    void note_acts_for_others(LinkId link) { links_[index(link)].acts_for_others = true; }
    /// Its channels must be closed. Erases the routes to it, and each conflict with fewer than two links left.
    void remove_link(LinkId link);
    /// Frames to `first`…`last` go to `link`. If called for several links, they go to all of them.
    void pin(std::uint8_t first, std::uint8_t last, LinkId link);
    void unpin(std::uint8_t first, std::uint8_t last, LinkId link);
    /// Where frames to unknown addresses go, for Unknown::link.
    void set_unknown_link(LinkId link) { unknown_links_ = link; }

    void open(ChannelId channel, LinkId link);
    /// Takes the new channel out of the group of its link: it is a place of its own, and never the home of a device that is pinned
    /// to another link.
    void leave_group(ChannelId channel);
    /// 0: none.
    std::uint8_t group_of(ChannelId channel) const noexcept {
        return apart_.contains(channel) ? std::uint8_t{0} : links_[index(link_of_[index(channel)])].group;
    }
    /// Erases all that was learned from it. An address that was at home only there moves to its claimant.
    void close(ChannelId channel);
    /// Assigns the port id to this channel until it is closed, and not to the other channels of its link.
    void bear(ChannelId channel, std::uint8_t port_id) { port_channels_[port_id].insert(channel); }
    /// Its wire is disconnected, the channel stays open. A device that is received elsewhere then has moved; its old place is not
    /// asked.
    void went_down(ChannelId channel);
    /// Its wire is connected again. Its group does not choose it before a frame is received: the other end may not be in use.
    void came_up(ChannelId channel) {
        down_.erase(channel);
        report_unreachable(link_of_[index(channel)]);
    }
    bool are_all_down(ChannelSet channels) const noexcept { return (channels - down_).empty(); }
    /// Whether a channel of another link of its group is connected.
    bool has_connected_mate(ChannelId channel) const noexcept { return !are_all_down(mates(channel)); }
    /// A command is to be sent on `channel`.
    void note_command(ChannelId channel, TimePoint now) noexcept { commanded_at_[index(channel)] = now; }
    /// Whether that was so after `since` on a connected channel of another link of its group.
    bool has_newer_command_of_mate(ChannelId channel, TimePoint since) const noexcept;
    /// Frames sent on this link were refused: its group uses another link until a frame is received on this one.
    void report_unreachable(LinkId link) { heard_link_[index(link)] = TimePoint::min(); }

    /// Learns that `source` is behind `from`, or begins to test its claim. Returns the channels for the frame, never `from`
    /// itself.
    Route route(ChannelId from, std::uint8_t source, std::uint8_t destination, TimePoint now,
                ano::Intent intent = ano::Intent::informs);

    /// As route(), but learns nothing.
    Route spread(ChannelId from, std::uint8_t source, std::uint8_t destination, TimePoint now,
                 ano::Intent intent = ano::Intent::informs);
    /// The part of route() without learning, for frames of the gateway itself: as if received on `from`, but on none of its
    /// channels.
    Route find(LinkId from, std::uint8_t destination, TimePoint now, ano::Intent intent = ano::Intent::informs);

    /// A host is behind the channel, although its address is not one of the host addresses.
    void note_host(ChannelId channel) noexcept { hosts_.insert(channel); }
    /// Only `source` was received on the channel: no other device and no host.
    bool is_alone(std::uint8_t source, ChannelId channel) const noexcept;

    /// Erases the route of `address`, and each claim and conflict about it. False: it had no route.
    bool forget(std::uint8_t address);

    /// The learning part of route(), for a frame that is not routed.
    void learn(ChannelId from, std::uint8_t source, TimePoint now);

    /// When `address` was received on `channel`; std::nullopt: it is not at home there.
    std::optional<TimePoint> heard_at(std::uint8_t address, ChannelId channel) const noexcept;
    /// The addresses that are at home only on this link, or were until its channels were closed.
    std::bitset<256> last_homes(LinkId link) const noexcept;
    /// Restores that these addresses were last at home on `link`, except those that are at home now.
    void restore_last_homes(const std::bitset<256>& addresses, LinkId link) noexcept;
    /// Whether it was at home there before it moved: a frame received there then means that it has returned.
    bool was_first(std::uint8_t source, ChannelId channel) const noexcept;
    /// Restores from an earlier run that `source` was at home there and was received at `at`. Ignored if it was learned since.
    void restore(std::uint8_t source, ChannelId channel, TimePoint at);
    /// Restores was_first().
    void restore_first(std::uint8_t source, ChannelId channel) { first_[source].insert(channel); }

    /// Call for a dropped frame too: it shows that its source is active, if that is at home there or was first. True: there is a
    /// new conflict.
    bool heard_again(ChannelId from, std::uint8_t source, TimePoint now);

    /// `source` is at home behind `channel`: learned there; or pinned to its link, and not at home behind another of its
    /// channels.
    bool holds(std::uint8_t source, ChannelId channel) const noexcept;
    /// Whether a frame of `source` on `channel` is a claim: `source` is at home elsewhere, and that place is not known to be
    /// down. In a group a device has one home on each link; hosts are at home everywhere. A pinned address has a home on each of
    /// its links and of their groups, and on no other.
    bool claims(std::uint8_t source, ChannelId channel) const noexcept;

    /// A question to the holder of an address, to test whether it still answers. It is sent on `channels`; only an answer from
    /// there counts.
    struct Question {
        std::uint8_t address = 0;
        ChannelSet channels;
    };
    bool has_question(TimePoint now) const noexcept { return claims_.is_due(now); }
    /// The next question that is due; std::nullopt: none. If the holder answers none of them, the address moves.
    std::optional<Question> pop_question(TimePoint now);
    /// When to call pop_question(); std::nullopt: no test is in progress.
    std::optional<TimePoint> next_question() const noexcept { return claims_.next(); }

    /// Records that the same source was received on `links`, which are not of one group, on one of them by `claimant`. route()
    /// detects only refused claims of the frames it routes.
    void note_conflict(std::uint8_t source, LinkSet links, std::optional<ChannelId> claimant, TimePoint now);

    struct Learned {
        LinkSet links;
        TimePoint last{};
    };
    /// For the status: the route of `address` at `now`; `links` is empty if there is none.
    Learned learned(std::uint8_t address, TimePoint now) const;
    LinkSet pinned(std::uint8_t address) const { return pinned_[address]; }
    LinkSet group(std::uint8_t number) const { return groups_[number]; }
    /// The links that have the port id, or a channel with it.
    LinkSet port(std::uint8_t address) const {
        return address <= ano::address::last_port_id ? ports_[address] | links_of(port_channels_[address]) : LinkSet{};
    }
    /// The conflicts seen within forget_after.
    std::vector<Conflict> conflicts(TimePoint now) const;
    struct Claimant {
        std::uint8_t address = 0;
        ChannelId channel{};
    };
    /// The next refused claim that was not returned yet. Call it before the channel can be closed.
    bool pop_claimant(Claimant& claimant);
    /// The next conflict that began and was not returned yet; for the log.
    bool pop_new_conflict(Conflict& conflict);
    /// A device that is at home on another link than before.
    struct Moved {
        std::uint8_t address = 0;
        LinkSet from;
        LinkId to{};
    };
    /// The next move that was not returned yet; for the log.
    std::optional<Moved> pop_move() noexcept;
    /// The links where the address was at home before it moved, until it returns.
    LinkSet moved_from(std::uint8_t address) const { return moved_from_[address]; }
    std::uint64_t own_frames() const { return own_frames_; }

private:
    ChannelSet heard_from(std::uint8_t address, TimePoint now) const;
    void claim(std::uint8_t source, ChannelId from, TimePoint now);
    void refuse(std::uint8_t source, TimePoint now);
    void keep_conflict(std::uint8_t source, TimePoint now) noexcept;
    /// `source` is pinned, and neither to the link of `channel` nor to one of the group of `channel`.
    bool is_outside(std::uint8_t source, ChannelId channel) const noexcept;
    /// The homes of `source` that exclude one behind `channel`.
    ChannelSet rivals(std::uint8_t source, ChannelId channel) const noexcept;
    ChannelSet bounds(std::uint8_t source, ChannelId channel) const noexcept;
    void to_pinned(Route& route, std::uint8_t destination) const;
    void settle();
    void forget_conflict(std::uint8_t address);
    /// Removes the first address from `unreported`, which is new_conflicts_ or new_claimants_, and returns it.
    std::optional<std::uint8_t> pop_first(std::bitset<256>& unreported);
    void move(std::uint8_t source, ChannelId to);
    void note_move(std::uint8_t source, ChannelId to) noexcept;
    void come_back(std::uint8_t source, ChannelId from, TimePoint now);
    bool is_cut_off(ChannelSet known) const noexcept;
    LinkSet links_of(ChannelSet channels) const noexcept;
    ChannelSet channels_of(LinkSet links) const noexcept;
    void decide(Route& route, std::uint8_t destination, ano::Intent intent, TimePoint now);
    void to_namesakes(Route& route, std::uint8_t address, ChannelId from, ano::Intent intent);
    bool to_last_home(Route& route, std::uint8_t destination);
    void add_unknown(Route& route, std::uint8_t destination, ano::Intent intent);
    ChannelSet devices();
    ChannelSet places_of(ChannelSet channels) const noexcept;
    ChannelSet places_of_devices_alone() { return places_of(devices()) - places_of_hosts(); }
    ChannelSet places_of_hosts() const noexcept {
        return places_of(hosts_ | known_[ano::address::host] | known_[ano::address::ros_bridge]);
    }
    ChannelSet the_only_place(ChannelSet devices) const noexcept;
    bool is_unheard(LinkId link) const noexcept { return (channels_of_link_[index(link)] & (heard_any_ | hosts_)).empty(); }
    bool is_port(std::uint8_t destination) const noexcept {
        return destination <= ano::address::last_port_id && !(ports_[destination].empty() && port_channels_[destination].empty());
    }
    void guard(Route& route, std::uint8_t destination) const noexcept;
    void to_links(Route& route, LinkSet links) const;
    void keep_homes(ChannelSet& channels, LinkSet links, ChannelSet homes) const noexcept;
    void keep_one_of_each_group(Route& route, LinkId from, std::uint8_t its_group, std::uint8_t destination, ano::Intent intent,
                                TimePoint now) const;
    LinkSet best_of(LinkSet group, ChannelSet able, ano::Intent intent, TimePoint now) const;
    LinkSet links_beside(LinkId link) const noexcept;
    ChannelSet members(std::uint8_t group) const noexcept { return channels_of(groups_[group]) - apart_; }
    ChannelSet mates(ChannelId channel) const noexcept;
    TimePoint& heard(std::uint8_t address, ChannelId channel) { return heard_[address][index(channel)]; }
    TimePoint heard(std::uint8_t address, ChannelId channel) const { return heard_[address][index(channel)]; }

    Duration forget_after_{};
    std::uint8_t own_id_ = 0;
    Unknown unknown_ = Unknown::flood;
    LinkSet unknown_links_;

    LinkSet used_;
    std::array<LinkRule, max_links> links_{};
    std::array<LinkSet, ano::address::last_port_id + 1> ports_{};
    std::array<ChannelSet, ano::address::last_port_id + 1> port_channels_{};
    std::array<LinkSet, 256> pinned_{};

    std::array<LinkSet, max_links + 1> groups_{};           // by number; [0] is unused
    unsigned open_ = 0;                                     // channels
    bool grouped_ = false;                                  // any link has a group
    std::array<TimePoint, max_channels> commanded_at_{};    // zero: never
    std::array<TimePoint, max_links> heard_link_ = [] {
        std::array<TimePoint, max_links> all;
        all.fill(TimePoint::min());
        return all;
    }();

    std::array<LinkId, max_channels> link_of_{};
    std::array<ChannelSet, max_links> channels_of_link_{};
    ChannelSet flooded_;      // channels whose link accepts floods
    ChannelSet broadcast_;    // channels whose link accepts broadcasts
    ChannelSet down_;         // channels whose wire is disconnected
    ChannelSet hosts_;        // channels of note_host()
    ChannelSet apart_;        // channels that are not in the group of their link
    ChannelSet devices_;      // channels where a device is at home, or was last; valid unless homes_changed_
    ChannelSet heard_any_;    // channels where any address is at home; valid as devices_
    ChannelSet silent_;       // those of devices_ on which nothing was received since
    bool homes_changed_ = false;

    // Where an address is at home, and when it was received there. This is kept for any time: a silent device may still be there,
    // and is asked. Exact times need no periodic sweep. A frame accesses only the words of its two addresses, and one time per
    // channel on which they were received.
    std::array<ChannelSet, 256> known_{};
    std::array<std::array<TimePoint, max_channels>, 256> heard_{};
    // The link where an address was at home until its channel was closed; for addresses without a home.
    std::array<LinkSet, 256> left_{};
    LinkSet remade_;    // links of restore_last_homes()
    // Where an address was at home before it moved, while it is elsewhere. A frame received there means that it has returned.
    std::array<ChannelSet, 256> first_{};

    // The links of first_, and the addresses whose last move was not returned yet.
    std::array<LinkSet, 256> moved_from_{};
    std::bitset<256> new_moves_;

    // Where an address was received while it is at home elsewhere: a host and a device that have the same address.
    std::array<ChannelSet, 256> also_{};

    Claims claims_;
    // The earliest time at which the next claim of a pinned address by another link is counted.
    std::array<TimePoint, 256> next_refusal_{};
    std::array<Conflict, 256> conflicts_{};
    std::bitset<256> new_conflicts_;
    std::array<ChannelId, 256> claimants_{};
    std::bitset<256> new_claimants_;
    bool has_unreported_ = false;    // new_conflicts_ or new_claimants_ is not empty
    std::uint64_t own_frames_ = 0;
};

}    // namespace anogate
