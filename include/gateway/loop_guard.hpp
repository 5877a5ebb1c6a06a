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
// - What a replay says, its device may say as well, with the same bytes: it passes, and a probe leaves by the channel that brought
//   it, as for hosts. Nothing but a ring that is known ends it.
// - More than RingWatch::storm in a second come from a ring whatever the probe said.
#pragma once
#include <gateway/expiring_cache.hpp>
#include <gateway/ids.hpp>
#include <gateway/ring_watch.hpp>
#include <gateway/said.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
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
    void open(ChannelId channel, LinkId link, std::uint8_t group, bool probed, TimePoint now) noexcept;
    void close(ChannelId channel) noexcept { rings_.close(channel); }
    /// The link is no more, its channels are closed: what came by it is forgotten, and that anything went there.
    void remove_link(LinkId link) noexcept;

    /// A frame that came in by `from`. A copy that waited to be read is one all the same.
    Judgement judge(const Said& said, ChannelId from, TimePoint now) noexcept {
        const TimePoint arrived = std::min(said.arrived, now);
        return arrived >= quiet_at_ ? Judgement{} : look_up(said, from, arrived, now);
    }

    /// A frame that came by `from` and passed went, or could come back, by each of `channels`: Route::guarded.
    void remember(const Said& said, ChannelId from, ChannelSet channels, TimePoint now) noexcept;

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
        bool replayed = false;               // `from` is a replay
        Test test{};
        TimePoint withheld_until = TimePoint::min();
    };
    struct Withheld {
        std::uint32_t frames = 0;
        TimePoint since{};    // the first of a row
        TimePoint at{};       // the last
    };
    static constexpr std::uint8_t max_withheld_frames = 255, max_anticipated = 31;

    Judgement look_up(const Said& said, ChannelId from, TimePoint arrived, TimePoint now) noexcept;
    Judgement judge(Sent& known, const Said& said, ChannelId from, TimePoint now) noexcept;
    Judgement repeated(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept;
    Judgement said_again(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept;
    Judgement said_beside_replay(ChannelId from, TimePoint sent_at, TimePoint now) noexcept;
    Judgement blindly(const Said& said, TimePoint now) const noexcept;
    Judgement paced(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept;
    Judgement tested(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept;
    Judgement came_round(Sent& known, ChannelId from, TimePoint now) noexcept;
    static void end_test(Sent& known) noexcept;
    static Judgement waiting(const Said& said, TimePoint sent_at, bool probe, TimePoint now) noexcept;
    bool may_be_its_other_end(const Sent& known, ChannelId from, TimePoint sent_at, TimePoint now) noexcept;
    bool is_clear(const Sent& known, ChannelId from, TimePoint now) noexcept;
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
    // Of a channel that has no link.
    static constexpr std::uint8_t place_of_its_own(std::size_t channel) noexcept {
        return static_cast<std::uint8_t>(2 * max_links + 1 + channel);
    }
    bool same_place(ChannelId a, ChannelId b) const noexcept { return place_of_[index(a)] == place_of_[index(b)]; }

    Duration window_;
    ExpiringCache<Sent> sent_;
    RingWatch rings_;
    TimePoint quiet_at_ = TimePoint::min();
    std::array<TimePoint, max_channels> opened_at_ = [] {
        std::array<TimePoint, max_channels> all;
        all.fill(TimePoint::min());
        return all;
    }();
    std::array<Withheld, max_channels> withheld_{};
    std::array<LinkId, max_channels> link_of_{};
    std::array<std::uint8_t, max_channels> place_of_ = [] {    // each alone until it is opened
        std::array<std::uint8_t, max_channels> all;
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = place_of_its_own(i);
        return all;
    }();
};

}    // namespace anogate
