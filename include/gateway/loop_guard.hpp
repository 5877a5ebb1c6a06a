// Keeps what was spread to several channels from coming back and going round: two gateways joined by two links.
//
// What a peer says itself is never kept back, so returns are told from repeats:
// - A device has an address of its own. Its bytes by another channel than they came by first are a copy, and end here. Who
//   repeats them from elsewhere takes nothing from it: as many of its own end as were said in its name, and not one more.
// - Many may be host. What one host said, another may say: it passes, and a probe leaves by the channel that brought it. In a
//   ring the probe comes back: what comes back by that ring then ends here. What has passed twice waits until the probe is
//   answered or `patience` is over.
// - Where no probe may go (serial ports, CAN), all do when the other end does not bring back what devices say, or half of what
//   hosts say, or when it can't have left by any other channel that may be in a ring; none when the other end brought back what
//   a device said. While nothing of that is known, one return passes within the window.
// - What enters by the ring itself comes again by the channel that brought it first, as from a sender that repeats itself. A
//   probe tells them apart as well; for a device only where repeats are faster than a device speaks.
// - A ring that lets no probe through looks like a sender that repeats itself. So after 64 repeats, 128 and so on a command is
//   tested: it is withheld for a while. When the next comes meanwhile, it is a sender's, and goes on with it. Else it is sent
//   late: in a ring it comes back as long after that as ever, whenever it was sent; a sender says it by its own clock. When it
//   came back so three times in a row, withheld for three different times, it ends. So does, once in a test, what is said
//   again only when it arrived, by a sender that waits longer for that.
// - What that can't tell: of the thousandth repeat on, the frame is withheld, and sent together with the next: a sender loses
//   nothing by that, while in a ring there is no next. After twice as many, twice as many are withheld, for as many may go
//   round; but never for longer than `max_withheld`.
// - More than RingWatch::storm in a second come from a ring whatever the probe said.
#pragma once
#include <gateway/recent.hpp>
#include <gateway/ring_watch.hpp>
#include <gateway/said.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <utility>

namespace anogate {

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
    static constexpr Duration max_withheld = std::chrono::milliseconds{500}, max_state_withheld = std::chrono::milliseconds{100};
    /// Nobody says the same again so soon, so many times in a row; in a known ring one that does so once is a copy.
    static constexpr Duration faster_than_senders = std::chrono::milliseconds{5};
    static constexpr std::uint32_t fast_repeats = 32;
    /// After so many repeats a command is tested first, and after twice as many each time then; how long it is withheld, in
    /// turn; and how often it comes round as it would in a ring until it is taken for that.
    static constexpr std::uint32_t first_test = 64, max_tests = 4;
    static constexpr std::array<Duration, 3> tested_for{max_withheld, std::chrono::milliseconds{300},
                                                        std::chrono::milliseconds{400}};
    static constexpr std::uint8_t enough = 3;
    /// What goes round together, sent late at once, comes within this time.
    static constexpr Duration come_together = std::chrono::milliseconds{100};
    /// Of states that a ring may have multiplied: shorter than sticks may be old. Commands wait for RingWatch::patience.
    static constexpr Duration max_state_wait = std::chrono::milliseconds{150};

    enum class Fate : std::uint8_t {
        passes,
        waits,       // for Judgement::wait; then it is judged again, as one that waited, and if it is to wait still, it passes
        withheld,    // sent with the next of the same; counted when there is none: take_lost()
        ends,        // it came round
    };
    struct Judgement {
        Fate fate = Fate::passes;
        bool probe = false;          // rings().ask() should leave by the channel first
        std::uint32_t copies = 1;    // so often it is to leave: those withheld before it as well
        bool elsewhere = false;      // it ends, and may be what a device on two links said, not a copy of ours
        Duration wait{};
        std::uint32_t repeats = 0;    // when the channel brings the same more often while it waits, it need not wait any longer
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

    /// A frame that came in by `from`. A copy that waited to be read is one all the same.
    Judgement judge(const Said& said, ChannelId from, TimePoint now) noexcept {
        const TimePoint arrived = std::min(said.arrived, now);
        if (arrived >= quiet_at_) return {};
        Sent* known = sent_.find(said.key, arrived);
        if (!known) return {};
        const Judgement judgement = judge(*known, said, from, now);
        if (judgement.fate == Fate::withheld || now < known->withheld_until) {    // its next is awaited as long as another
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
        if (!said.by_host && said.to_all) rings_.told(channels, now);
        if (const ChannelSet back = (channels - from) & rings_.rings(); !back.empty())
            sent.owed = static_cast<std::uint8_t>(std::min<std::size_t>(sent.owed + back.size(), max_channels));
        if (sent.claimed && claimed && sent.anticipated < max_anticipated) ++sent.anticipated;
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
    // Whether it comes round, as long after it was sent as ever.
    struct Test {
        std::uint8_t number = 0;    // those that are over
        std::uint8_t sent_late = 0;
        std::uint8_t steady = 0, strays = 0;
        std::uint16_t way = 0;    // from the last time that it was sent to this; ms
    };
    struct Sent {
        ChannelSet channels;
        ChannelSet returned;        // of them and of others, by which it came again
        std::uint32_t times = 0;    // it came once more
        ChannelId from{};           // by which it came first
        std::uint8_t withheld = 0;
        std::uint8_t owed = 0;               // went out by rings and may come back by `from`
        bool again : 1 = false;              // another channel brought it while nobody knew,
        bool blindly : 1 = false;            // and nobody could ask
        bool claimed : 1 = false;            // `from` is not the home of its source,
        std::uint8_t anticipated : 5 = 0;    // and brought it so often before that did
        Test test{};
        TimePoint withheld_until = TimePoint::min();
    };
    struct Withheld {
        std::uint32_t frames = 0;
        TimePoint since{};    // the first of a row
        TimePoint at{};       // the last
    };
    static constexpr std::uint8_t max_withheld_frames = 255, max_anticipated = 31;

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
        return {.fate = Fate::ends,
                .probe = rings_.is_due(from, now, knows(from, now) ? RingWatch::calm : RingWatch::spacing),
                .elsewhere = !rings_.is_probed(from) || rings_.is_clear(from, now)};
    }
    // By the channel that brought it first.
    Judgement repeated(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
        if (!said.by_host) {
            const bool fast = now - sent_at < faster_than_senders;
            if (fast && rings_.is_ring(from, now)) return {Fate::ends};
            const bool often = known.times % fast_repeats == fast_repeats - 1;
            return with_probe(paced(known, said, from, sent_at, now), fast && often && is_worth_asking(from, now));
        }
        if (rings_.is_ring(from, now)) {
            const bool before_it_was_known = sent_at <= rings_.ring_since(from) && !(known.channels - from).empty();
            if (known.owed == 0 && !known.again && !before_it_was_known) return paced(known, said, from, sent_at, now);
            if (known.owed > 0) --known.owed;
            return {Fate::ends};
        }
        const bool probe = is_worth_asking(from, now);
        if (!known.again || is_clear(known, from, now)) return with_probe(paced(known, said, from, sent_at, now), probe);
        if (rings_.is_asking(now)) return waiting(said, sent_at, probe, now);
        const bool undecided = known.blindly && !rings_.is_probed(from) && known.channels.contains(from);
        return undecided ? Judgement{Fate::ends} : with_probe(paced(known, said, from, sent_at, now), probe);
    }
    // By another, and who says it may be another host.
    Judgement said_again(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
        if (rings_.is_ring(from, now)) return {Fate::ends, rings_.is_due(from, now, RingWatch::calm)};
        const bool first = !known.returned.contains(from);
        known.returned.insert(from);
        if (rings_.brought_back(from, first, sent_at, now)) return {Fate::ends, rings_.is_due(from, now)};
        const bool probe = rings_.is_due(from, now);
        if (is_clear(known, from, now)) {
            const bool may_be_answered = rings_.is_new(from, now) && now - sent_at < RingWatch::by_hand;
            if (may_be_answered || may_be_its_other_end(known, from, sent_at, now)) return waiting(said, sent_at, probe, now);
            return with_probe(paced(known, said, from, sent_at, now), probe);
        }
        if (!known.again) {
            known.again = true;
            known.blindly = !rings_.is_probed(from);
            if (known.blindly || known.times == 0) return with_probe(paced(known, said, from, sent_at, now), probe);
        }
        return rings_.is_probed(from) ? waiting(said, sent_at, probe, now) : blindly(said, now);
    }
    // Nobody knows, and nobody can ask; unless somebody just did, by a way that it may have left by.
    Judgement blindly(const Said& said, TimePoint now) const noexcept {
        if (!said.command || said.waited || !rings_.is_asking(now)) return {Fate::ends};
        return {.fate = Fate::waits, .wait = RingWatch::patience};
    }
    // It passes, unless it was repeated so often that it is time to see whether it comes without us as well.
    Judgement paced(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
        known.times += !said.waited;
        if (const Judgement judgement = tested(known, said, from, sent_at, now); judgement.fate != Fate::passes) return judgement;
        Withheld& withheld = withheld_[index(known.from)];
        const std::uint32_t turns = known.times / repeats;
        if (turns > 0 && !said.waited && known.withheld < max_withheld_frames) {
            const std::uint32_t most = std::bit_floor(turns);
            if (known.withheld == 0) withheld.since = now;
            const bool in_time = now - withheld.since < (said.state ? max_state_withheld : max_withheld);
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
    // Sent late, the next of a sender comes by its own clock; in a ring nothing comes before, and always as long after.
    Judgement tested(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
        Test& test = known.test;
        if (said.waited) {
            if (said.hurried && test.sent_late > 0) end_test(known);
            return {};
        }
        if (now >= known.withheld_until) {
            const auto way = static_cast<std::uint16_t>(
                std::min<std::int64_t>((now - sent_at) / std::chrono::milliseconds{1}, 60'000));
            const bool steady = std::abs(way - test.way) <= std::min(20 + way / 8, 60);
            test.way = way;
            if (test.sent_late == 0) {
                const std::uint32_t turns = (known.times / first_test) >>
                                            test.number;    // of several that go round none is steady
                if (!said.command || test.number == max_tests || turns < (steady ? 1u : 2u)) return {};
            } else if (steady) {
                if (++test.steady >= enough) return came_round(known, from, now);
            } else {
                const bool ended = test.steady == enough;    // and yet it goes on
                test.steady = 0;
                if (ended || ++test.strays > 1) return end_test(known), Judgement{};
            }
            known.withheld_until = now + tested_for[test.sent_late++ % tested_for.size()];
        }
        return {.fate = Fate::waits, .wait = known.withheld_until - now, .repeats = std::max(known.times / first_test, 1u)};
    }
    // Others that go round with it end as well.
    Judgement came_round(Sent& known, ChannelId from, TimePoint now) noexcept {
        known.test.steady = enough;
        if (known.from != from) rings_.came_round(from, now);
        return {Fate::ends};
    }
    static void end_test(Sent& known) noexcept {
        known.test = {.number = static_cast<std::uint8_t>(known.test.number + 1), .way = known.test.way};
        known.withheld_until = TimePoint::min();
    }
    // Of states the newest counts, so they wait only where a ring turns fast, and not for long.
    static constexpr Judgement waiting(const Said& said, TimePoint sent_at, bool probe, TimePoint now) noexcept {
        const bool waits = !said.state || now - sent_at < faster_than_senders;
        return {.fate = waits ? Fate::waits : Fate::passes,
                .probe = probe,
                .wait = said.state ? max_state_wait : RingWatch::patience};
    }
    // Of a ring by bridges that keep what devices say: there a probe tells, by its other end.
    bool may_be_its_other_end(const Sent& known, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
        if (rings_.is_probed(from) || known.times == 0) return false;
        return rings_.is_asking(now) || (now - sent_at < RingWatch::by_hand && !rings_.are_clear(known.channels - from, now));
    }
    // No ring that it can have come by.
    bool is_clear(const Sent& known, ChannelId from, TimePoint now) noexcept {
        return rings_.is_clear(from, now) || (!rings_.is_probed(from) && rings_.are_clear(known.channels - from, now));
    }
    bool is_worth_asking(ChannelId channel, TimePoint now) noexcept {
        return !rings_.is_clear(channel, now) && rings_.is_due(channel, now);
    }
    static Judgement with_probe(Judgement judgement, bool probe) noexcept {
        judgement.probe = probe;
        return judgement;
    }
    bool knows(ChannelId channel, TimePoint now) noexcept {
        return rings_.is_ring(channel, now) || rings_.is_clear(channel, now);
    }

    // Links of one group lead to one place.
    static constexpr std::uint8_t place(LinkId link, std::uint8_t group) noexcept {
        return static_cast<std::uint8_t>(group == 0 ? index(link) : max_links + group);
    }
    bool same_place(ChannelId a, ChannelId b) const noexcept { return place_of_[index(a)] == place_of_[index(b)]; }

    Duration window_;
    Recent<Sent> sent_;
    RingWatch rings_;
    TimePoint quiet_at_ = TimePoint::min();
    std::array<TimePoint, max_channels> opened_at_ = [] {
        std::array<TimePoint, max_channels> all;
        all.fill(TimePoint::min());
        return all;
    }();
    std::array<Withheld, max_channels> withheld_{};
    std::array<std::uint8_t, max_channels> place_of_ = [] {    // each alone until it is opened
        std::array<std::uint8_t, max_channels> all;
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
        return all;
    }();
};

}    // namespace anogate
