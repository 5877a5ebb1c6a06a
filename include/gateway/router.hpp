// Who gets a frame. Knows no bytes, no sockets and no clock (protocol text, section 2; config/README.md, "Where frames go").
#pragma once
#include <ano/address.hpp>
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

/// Where one frame goes: to every channel of `channels`, and to `absent`, links that were meant but have no channel
/// now.
struct Route {
    ChannelSet channels;
    LinkSet absent;
    Via via = Via::nobody;
    bool new_conflict = false;    // Router::take_claimant() and take_new_conflict() have something
    bool host_is_down = false;    // a host, heard only where the wire is gone now
    /// Where a frame that was spread may come back: what the loop guard is to remember. Empty for one that had one
    /// place, unless that is a host.
    ChannelSet guarded{};
};

/// Somebody spoke as a source that is alive elsewhere: two devices with one id, one device by two ways, or a thief.
struct Conflict {
    std::uint8_t address = 0;
    LinkSet links;
    bool claimed = false;    // Router::take_claimant() knew by whom
    TimePoint last{};
    std::uint64_t count = 0;    // how often it showed: claims that were refused, and the same frames by two links
};

/// Constant time a frame; no allocation after the links are known.
class Router {
public:
    struct LinkRule {
        std::uint8_t port_id = 0;    // 0: none
        bool flood = true;
        bool broadcast = true;
        std::uint8_t group = 0;    // 1 to 64: links of one number lead to the same place; 0: none
        bool teaches = true;       // who speaks by it is there. False: it says what was said once
    };

    /// Of several channels that have a device, those that heard it this lately get its frames.
    static constexpr Duration moved_after = std::chrono::seconds{3};
    /// When no link of a group was heard for this long, none is known to work: all of them get its frames.
    static constexpr Duration group_silence = std::chrono::seconds{1};

    explicit Router(const GatewaySettings& settings);
    /// Other settings from now on. The link for unheard addresses is to be told anew.
    void set(const GatewaySettings& settings);

    /// The lowest number that is free; there is one.
    LinkId add_link(const LinkRule& rule);
    /// Its channels are closed. Forgets what leads to it and every conflict that is none without it.
    void remove_link(LinkId link);
    /// Frames to `first`…`last` go to `link`; to every such link when called for several.
    void pin(std::uint8_t first, std::uint8_t last, LinkId link);
    void unpin(std::uint8_t first, std::uint8_t last, LinkId link);
    /// Where frames to unheard addresses go, for Unknown::link.
    void set_unknown_link(LinkId link) { unknown_links_ = link; }

    void open(ChannelId channel, LinkId link);
    /// Forgets everything that was learned from it. What was held by it alone goes to who claims it.
    void close(ChannelId channel);
    /// The channel, by itself, bears the port id until it is closed: as a link of that id, without the other channels of its link.
    void bear(ChannelId channel, std::uint8_t port_id) { port_channels_[port_id].insert(channel); }
    /// The wire behind it is gone, the channel stays: a device that turns up elsewhere has moved, it is not asked for.
    void went_down(ChannelId channel);
    /// The wire behind it is there again.
    void came_up(ChannelId channel) { down_.erase(channel); }
    bool are_all_down(ChannelSet channels) const noexcept { return (channels - down_).empty(); }
    /// What was sent by this link did not arrive (a refusal): its group looks for another until it is heard again.
    void report_unreachable(LinkId link) { heard_link_[index(link)] = TimePoint::min(); }

    /// Learns `source` as behind `from`, or begins to test its claim, and says who gets the frame; never `from` itself.
    Route route(ChannelId from, std::uint8_t source, std::uint8_t destination, TimePoint now);

    /// The other half: who gets what the gateway itself sends, as if it had come by `from` and by none of its channels.
    Route find(LinkId from, std::uint8_t destination, TimePoint now);

    /// Forgets where `address` was heard, and every claim and conflict about it. False: it was nowhere.
    bool forget(std::uint8_t address);

    /// The half of route() that a frame has in which the gateway finds something else to do than to route it.
    void learn(ChannelId from, std::uint8_t source, TimePoint now);

    /// When `address` was heard by `channel`, where it is at home; nothing: it is not.
    std::optional<TimePoint> heard_at(std::uint8_t address, ChannelId channel) const noexcept;
    /// Whether it was at home there before it moved: when it speaks there, it is back.
    bool was_first(std::uint8_t source, ChannelId channel) const noexcept;
    /// `source` was at home there when the program ran before, and was heard at `at`. Not for one that was learned since.
    void restore(std::uint8_t source, ChannelId channel, TimePoint at);
    /// It was_first() there.
    void restore_first(std::uint8_t source, ChannelId channel) { first_[source].insert(channel); }

    /// A frame that goes no further is a sign of life all the same, where its source is at home, or was first. True: that is a
    /// conflict.
    bool heard_again(ChannelId from, std::uint8_t source, TimePoint now);

    /// `source` is at home behind `channel`: pinned to its link, or learned there.
    bool holds(std::uint8_t source, ChannelId channel) const noexcept;
    /// `source` is at home elsewhere, and that is not known to be down: what comes by `channel` is a claim. Links of one group
    /// are one place, hosts are at home everywhere.
    bool claims(std::uint8_t source, ChannelId channel) const noexcept;

    /// What the LoopGuard is to know of a frame, before route() learns from it.
    Speaks speaks(std::uint8_t source, ChannelId channel) const noexcept;

    /// A holder to be asked whether it is still there; only it may answer.
    struct Question {
        std::uint8_t address = 0;
        ChannelSet channels;
    };
    bool has_question(TimePoint now) const noexcept { return claims_.is_due(now); }
    /// The questions that are due, one after the other. Where all were met with silence, the address moves.
    std::optional<Question> take_question(TimePoint now);
    /// When to look for questions; nothing: nobody is asked.
    std::optional<TimePoint> next_question() const noexcept { return claims_.next(); }

    /// `links`, of no common group, have brought the same source, `claimant` one of them. route() finds refused claims by
    /// itself, but of what it is given.
    void note_conflict(std::uint8_t source, LinkSet links, std::optional<ChannelId> claimant, TimePoint now);

    struct Learned {
        LinkSet links;
        TimePoint last{};
    };
    /// The status: what is known of `address` at `now`; `links` is empty when nothing is.
    Learned learned(std::uint8_t address, TimePoint now) const;
    LinkSet pinned(std::uint8_t address) const { return pinned_[address]; }
    LinkSet group(std::uint8_t number) const { return groups_[number]; }
    /// Those that bear the port id, or have a channel that does.
    LinkSet port(std::uint8_t address) const {
        return address <= ano::address::last_port_id ? ports_[address] | links_of(port_channels_[address]) : LinkSet{};
    }
    /// Those seen within forget_after.
    std::vector<Conflict> conflicts(TimePoint now) const;
    struct Claimant {
        std::uint8_t address = 0;
        ChannelId channel{};
    };
    /// Whose claim was refused last, where that was not taken yet. To be asked before the channel can be closed.
    bool take_claimant(Claimant& claimant);
    /// The next conflict that began and was not taken yet; for the log.
    bool take_new_conflict(Conflict& conflict);
    std::uint64_t own_frames() const { return own_frames_; }

private:
    ChannelSet heard_from(std::uint8_t address, TimePoint now) const;
    void claim(std::uint8_t source, ChannelId from, TimePoint now);
    void refuse(std::uint8_t source, TimePoint now);
    void settle();
    void forget_conflict(std::uint8_t address);
    /// Of the addresses in `untold`, new_conflicts_ or new_claimants_, the first: it counts as told now.
    std::optional<std::uint8_t> tell_first(std::bitset<256>& untold);
    void move(std::uint8_t source, ChannelId to);
    void come_back(std::uint8_t source, ChannelId from, TimePoint now);
    bool leads_to(ChannelSet known, ChannelId channel) const noexcept;
    bool is_cut_off(ChannelSet known) const noexcept;
    LinkSet links_of(ChannelSet channels) const noexcept;
    ChannelSet channels_of(LinkSet links) const;
    void decide(Route& route, std::uint8_t destination, TimePoint now);
    void add_unknown(Route& route) const;
    bool is_port(std::uint8_t destination) const noexcept {
        return destination <= ano::address::last_port_id && !(ports_[destination].empty() && port_channels_[destination].empty());
    }
    void guard(Route& route, std::uint8_t destination) const noexcept;
    void to_links(Route& route, LinkSet links) const;
    void keep_one_of_each_group(Route& route, LinkId from, TimePoint now) const;
    LinkSet best_of(LinkSet group, ChannelSet able, TimePoint now) const;
    LinkSet mates(LinkId link) const noexcept;
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

    std::array<LinkSet, max_links + 1> groups_{};    // by number; [0] is unused
    unsigned open_ = 0;                              // channels
    bool grouped_ = false;                           // any link has a group
    std::array<TimePoint, max_links> heard_link_ = [] {
        std::array<TimePoint, max_links> all;
        all.fill(TimePoint::min());
        return all;
    }();

    std::array<LinkId, max_channels> link_of_{};
    std::array<ChannelSet, max_links> channels_of_link_{};
    ChannelSet flooded_;      // channels whose link takes floods
    ChannelSet broadcast_;    // channels whose link takes broadcasts
    ChannelSet down_;         // channels whose wire is gone

    // Where an address is at home, and when it was heard there. It stays, however long ago: who is silent may still be there, and
    // is asked. Exact times rather than generations of sets: no sweep, and a frame touches the word of its two addresses and one
    // time for each channel that heard them.
    std::array<ChannelSet, 256> known_{};
    std::array<std::array<TimePoint, max_channels>, 256> heard_{};
    // Where it was at home before it moved, as long as it is elsewhere: when it speaks there, it is back.
    std::array<ChannelSet, 256> first_{};

    Claims claims_;
    std::array<Conflict, 256> conflicts_{};
    std::bitset<256> new_conflicts_;
    std::array<ChannelId, 256> claimants_{};
    std::bitset<256> new_claimants_;
    bool untold_ = false;    // any of these two
    std::uint64_t own_frames_ = 0;
};

}    // namespace anogate
