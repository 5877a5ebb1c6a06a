// Keeps what was spread to several channels from coming back and going round: two gateways joined by two links.
//
// What a peer says itself is never kept back, so returns are told from repeats:
// - A device has an address of its own. Its bytes by another channel than they came by first are a copy, and end here. Who
//   repeats them from elsewhere takes nothing from it: as many of its own end as were said in its name, and not one more.
// - Many may be host. What one host said, another may say: it passes, and a probe leaves by the channel that brought it. In a
//   ring the probe comes back: what comes back by that ring then ends here. What has passed twice waits until the probe is
//   answered or `patience` is over.
// - Where no probe may go (serial ports, CAN), one return passes within the window. More do when hosts are known to say things
//   that the other end does not bring back, none when the other end brought back what a device said.
// - What enters by the ring itself comes again by the channel that brought it first, as from a sender that repeats itself. A
//   probe tells them apart as well; for a device only where repeats are faster than a device speaks.
// - A ring that lets no probe through can't be told from a sender that repeats itself. Of the thousandth repeat on, the frame
//   is withheld, and sent together with the next: a sender loses nothing by that, while in a ring there is no next. After twice
//   as many, twice as many are withheld, for as many may go round; but never for longer than `longest_withheld`.
// - More than RingWatch::storm in a second come from a ring whatever the probe said.
#pragma once
#include <gateway/claims.hpp>
#include <gateway/recent.hpp>
#include <gateway/ring_watch.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>

namespace anogate {

/// What the guard has to know of a frame.
struct Said {
    std::uint64_t key;      // key_of()
    bool by_host;           // others may say the very same
    bool state = false;     // a newer one of its kind replaces it: sticks, telemetry
    Speaks speaks = Speaks::somewhere;
};
inline Said said_by(ano::FrameView frame) noexcept {
    return {key_of(frame), ano::address::is_host(frame.source()), treatment_of(frame.id()).replaces != Replaces::nothing};
}

/// Constant time, no allocation after construction.
class LoopGuard {
public:
    using Duration = ano::Duration;
    using TimePoint = ano::TimePoint;

    explicit LoopGuard(std::uint64_t station = 1, Duration window = std::chrono::seconds{2}, std::size_t capacity = 16 * 1024)
        : window_{window}, sent_{window, capacity}, rings_{station} {}

    /// From so many repeats of the same bytes on some are withheld until the next.
    static constexpr std::uint32_t repeats = 1000;
    /// From the first that is withheld to the next that leaves, at the most: whoever listens to sticks must not take their
    /// sender for lost.
    static constexpr Duration longest_withheld = std::chrono::milliseconds{500}, longest_state_withheld = std::chrono::milliseconds{100};
    /// Nobody says the same again so soon, so many times in a row; in a known ring one that does so once is a copy.
    static constexpr Duration faster_than_senders = std::chrono::milliseconds{5};
    static constexpr std::uint32_t fast_repeats = 32;

    enum class Fate : std::uint8_t {
        passes,
        waits,       // for RingWatch::patience (of states only those that come fast); when it is judged again and waits still, it passes
        withheld,    // sent with the next of the same; counted when there is none: take_lost()
        ends,        // it came round
    };
    struct Judgement {
        Fate fate = Fate::passes;
        bool probe = false;           // rings().ask() should leave by the channel first
        std::uint32_t copies = 1;     // so often it is to leave: those withheld before it as well
        bool elsewhere = false;       // it ends, and nothing of it went out by this channel: a device on two links, or a ring
    };

    /// The channel is new, one of `link`, which leads to the same place as those of its `group` (0: none); what went to one that
    /// had its number before does not count. `probed`: a probe may leave by it.
    void open(ChannelId channel, LinkId link, std::uint8_t group, bool probed, TimePoint now) noexcept {
        place_of_[index(channel)] = place(link, group);
        opened_at_[index(channel)] = now;
        withheld_[index(channel)] = {};
        rings_.open(channel, link, probed);
    }
    void close(ChannelId channel) noexcept { rings_.close(channel); }

    /// A frame that came in by `from`.
    Judgement judge(const Said& said, ChannelId from, TimePoint now) noexcept {
        if (now >= quiet_at_) return {};
        Sent* known = sent_.find(said.key, now);
        if (!known) return {};
        const Judgement judgement = judge(*known, said, from, now);
        if (judgement.fate == Fate::withheld) {    // its next is awaited as long as another
            sent_.put(said.key, *known, now);
            quiet_at_ = now + window_;
        }
        return judgement;
    }

    /// A frame that came by `from` and passed went, or could come back, by each of `channels`: Route::guarded.
    void remember(const Said& said, ChannelId from, ChannelSet channels, TimePoint now) noexcept {
        const bool claimed = said.speaks == Speaks::elsewhere;
        Sent sent;
        sent.claimed = claimed;
        sent.channels = channels;
        sent.from = from;
        if (const Sent* known = sent_.find(said.key, now)) {
            sent = *known;
            if (same_place(sent.from, from) && !sent.channels.contains(from)) sent.from = from;
            if (sent.claimed && said.speaks == Speaks::at_home) {
                sent.from = from;
                sent.claimed = false;
            }
            sent.channels |= channels;
        } else if (said.by_host) {
            rings_.spread(channels, now);
        }
        if (const ChannelSet back = (channels - from) & rings_.rings(); !back.empty())
            sent.owed = static_cast<std::uint8_t>(std::min<std::size_t>(sent.owed + back.size(), most_channels));
        if (sent.claimed && claimed && sent.anticipated < most_anticipated) ++sent.anticipated;
        sent_.put(said.key, sent, now);
        quiet_at_ = now + window_;
    }

    /// How many frames of the channel were withheld for good: counted once.
    std::uint32_t take_lost(ChannelId channel, TimePoint now) noexcept {
        Withheld& withheld = withheld_[index(channel)];
        if (withheld.frames == 0 || now < withheld.at + window_) return 0;
        return std::exchange(withheld.frames, 0);
    }

    RingWatch& rings() noexcept { return rings_; }
    const RingWatch& rings() const noexcept { return rings_; }

private:
    struct Sent {
        ChannelSet channels;
        ChannelSet returned;          // of them and of others, by which it came again
        std::uint32_t times = 0;      // it came once more
        ChannelId from{};             // by which it came first
        std::uint8_t withheld = 0;
        std::uint8_t owed = 0;        // went out by rings and may come back by `from`
        bool again : 1 = false;       // another channel brought it while nobody knew,
        bool blindly : 1 = false;     // and nobody could ask
        bool claimed : 1 = false;     // `from` is not the home of its source,
        std::uint8_t anticipated : 5 = 0;    // and brought it so often before that did
    };
    struct Withheld {
        std::uint32_t frames = 0;
        TimePoint since{};    // the first of a row
        TimePoint at{};       // the last
    };
    static constexpr std::uint8_t most_withheld = 255, most_anticipated = 31;

    Judgement judge(Sent& known, const Said& said, ChannelId from, TimePoint now) noexcept {
        const TimePoint sent_at = sent_.put_at(said.key);
        if (known.from == from) return repeated(known, said, from, sent_at, now);
        if (sent_at <= opened_at_[index(from)]) return {};
        const bool went = known.channels.contains(from);
        if (!went && same_place(known.from, from)) return {};    // a sender with a new port
        if (said.by_host) return said_again(known, said, from, sent_at, now);
        if (known.claimed && said.speaks == Speaks::at_home) {
            if (known.anticipated == 0) return {};
            --known.anticipated;
            return {Fate::ends, rings_.is_due(from, now, knows(from, now) ? RingWatch::calm : RingWatch::spacing)};
        }
        if (!went) return {.fate = Fate::ends, .elsewhere = true};
        rings_.brought_back_ones_own(from, now);
        return {Fate::ends, rings_.is_due(from, now, knows(from, now) ? RingWatch::calm : RingWatch::spacing)};
    }
    // By the channel that brought it first.
    Judgement repeated(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
        if (!said.by_host) {
            const bool fast = now - sent_at < faster_than_senders;
            if (fast && rings_.is_ring(from, now)) return {Fate::ends};
            const bool often = known.times % fast_repeats == fast_repeats - 1;
            return with_probe(paced(known, said, now), fast && often && is_worth_asking(from, now));
        }
        if (rings_.is_ring(from, now)) {
            const bool before_it_was_known = sent_at <= rings_.ring_since(from) && !(known.channels - from).empty();
            if (known.owed == 0 && !known.again && !before_it_was_known) return paced(known, said, now);
            if (known.owed > 0) --known.owed;
            return {Fate::ends};
        }
        if (!known.again || rings_.is_clear(from, now)) return with_probe(paced(known, said, now), is_worth_asking(from, now));
        if (rings_.is_asking(now)) return {waits(said, sent_at, now) ? Fate::waits : Fate::passes};
        const bool undecided = known.blindly && !rings_.is_probed(from) && known.channels.contains(from);
        return undecided ? Judgement{Fate::ends} : paced(known, said, now);
    }
    // By another, and who says it may be another host.
    Judgement said_again(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
        if (rings_.is_ring(from, now)) return {Fate::ends, rings_.is_due(from, now, RingWatch::calm)};
        const bool first = !known.returned.contains(from);
        known.returned.insert(from);
        if (rings_.brought_back(from, first, sent_at, now)) return {Fate::ends, rings_.is_due(from, now)};
        const bool probe = rings_.is_due(from, now);
        if (rings_.is_clear(from, now)) {
            if (rings_.is_new(from, now) && now - sent_at < RingWatch::by_hand && waits(said, sent_at, now)) return {Fate::waits, probe};
            return with_probe(paced(known, said, now), probe);
        }
        if (!known.again) {
            known.again = true;
            known.blindly = !rings_.is_probed(from);
            if (known.blindly || known.times == 0) return with_probe(paced(known, said, now), probe);
        }
        if (rings_.is_probed(from)) return {waits(said, sent_at, now) ? Fate::waits : Fate::passes, probe};
        return {Fate::ends};
    }
    // It passes, unless it was repeated so often that it is time to see whether it comes without us as well.
    Judgement paced(Sent& known, const Said& said, TimePoint now) noexcept {
        Withheld& withheld = withheld_[index(known.from)];
        const std::uint32_t turns = ++known.times / repeats;
        if (turns > 0 && known.withheld < most_withheld) {
            const std::uint32_t most = std::bit_floor(turns);
            if (known.withheld == 0) withheld.since = now;
            const bool in_time = now - withheld.since < (said.state ? longest_state_withheld : longest_withheld);
            if (in_time && known.times - most * repeats < most) {
                ++known.withheld;
                ++withheld.frames;
                withheld.at = now;
                return {Fate::withheld};
            }
        }
        if (known.withheld == 0) return {};
        withheld.frames -= std::min<std::uint32_t>(withheld.frames, known.withheld);
        return {Fate::passes, false, 1u + std::exchange(known.withheld, std::uint8_t{0})};
    }
    // Of states the newest counts, so they wait only where a ring turns fast.
    static constexpr bool waits(const Said& said, TimePoint sent_at, TimePoint now) noexcept {
        return !said.state || now - sent_at < faster_than_senders;
    }
    bool is_worth_asking(ChannelId channel, TimePoint now) noexcept {
        return !rings_.is_clear(channel, now) && rings_.is_due(channel, now);
    }
    static Judgement with_probe(Judgement judgement, bool probe) noexcept {
        judgement.probe = probe;
        return judgement;
    }
    bool knows(ChannelId channel, TimePoint now) noexcept { return rings_.is_ring(channel, now) || rings_.is_clear(channel, now); }

    // Links of one group lead to one place.
    static constexpr std::uint8_t place(LinkId link, std::uint8_t group) noexcept {
        return static_cast<std::uint8_t>(group == 0 ? index(link) : most_links + group);
    }
    bool same_place(ChannelId a, ChannelId b) const noexcept { return place_of_[index(a)] == place_of_[index(b)]; }

    Duration window_;
    Recent<Sent> sent_;
    RingWatch rings_;
    TimePoint quiet_at_ = TimePoint::min();
    std::array<TimePoint, most_channels> opened_at_ = [] {
        std::array<TimePoint, most_channels> all;
        all.fill(TimePoint::min());
        return all;
    }();
    std::array<Withheld, most_channels> withheld_{};
    std::array<std::uint8_t, most_channels> place_of_ = [] {    // each alone until it is opened
        std::array<std::uint8_t, most_channels> all;
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
        return all;
    }();
};

}  // namespace anogate
