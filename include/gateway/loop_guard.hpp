// Stops frames that were sent to several channels from coming back and circulating, as between two gateways joined by two links.
//
// A frame that a peer really sends must never be dropped, so returned copies have to be distinguished from repeats:
// - A device has an address of its own. Its bytes by another channel than the first one are a copy, and are dropped. If another
//   channel brings them before the device's own channel does, only as many frames of the device are dropped as came in its name.
// - Several hosts may share an address. What one host sent, another may send: it passes, and a probe leaves by the channel that
//   brought it. In a ring the probe comes back; from then on, what comes back by that ring is dropped. A frame that has passed
//   twice waits until the probe is answered or `patience` is over.
// - Where no probe may be sent (serial ports, CAN), all frames pass when the other end does not bring back what devices send, or
//   half of what hosts send, or when the frame can't have left by any other channel that may be in a ring; none pass when the other
//   end brought back what a device sent. While none of this is known, one return passes within the window.
// - A frame that enters from inside the ring comes again by the channel that brought it first, like the repeats of a sender. A probe
//   distinguishes them as well; for a device it is sent only where repeats are faster than a device sends.
// - A ring that lets no probe through looks like a sender that repeats a frame. So after 64 repeats, 128 and so on, a command is
//   tested: it is withheld for a while. If the next one comes meanwhile, it is a sender's, and both leave together. Otherwise it is
//   sent late: in a ring it comes back after the same delay as before, whenever it was sent; a sender repeats by its own clock. When
//   it came back like this three times in a row, withheld for three different times, it is dropped. This also hits, once in a test,
//   a sender that repeats a frame only after it has arrived, and waits longer for that.
// - For what this can't distinguish: from the thousandth repeat on, the frame is withheld, and sent together with the next one. A
//   sender loses nothing by that, while in a ring there is no next one. After twice as many repeats, twice as many are withheld,
//   since as many may circulate; but never for longer than `max_withheld`.
// - What a replay sends, its device may send as well, with the same bytes: it passes, and a probe leaves by the channel that brought
//   it, as for hosts. It is dropped only for a ring that is known.
// - More than RingWatch::storm frames in a second are taken for a ring, whatever the probe showed.
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

    /// From this many repeats of the same bytes on, some are withheld until the next one.
    static constexpr std::uint32_t repeats = 1000;
    /// The maximum time from the first withheld frame to the next that leaves: a receiver of sticks must not take their sender for
    /// lost.
    static constexpr Duration max_withheld = std::chrono::milliseconds{500}, max_state_withheld = std::chrono::milliseconds{100};
    /// No sender repeats the same bytes so soon, `fast_repeats` times in a row; in a known ring, a single repeat as fast is a copy.
    static constexpr Duration faster_than_senders = std::chrono::milliseconds{5};
    static constexpr std::uint32_t fast_repeats = 32;
    /// The first test of a command is after `first_test` repeats, each further one after twice as many. It is withheld for the times
    /// of `tested_for` in turn. When it has come back `enough` times as in a ring, it is taken for one.
    static constexpr std::uint32_t first_test = 64, max_tests = 4;
    static constexpr std::array<Duration, 3> tested_for{max_withheld, std::chrono::milliseconds{300},
                                                        std::chrono::milliseconds{400}};
    static constexpr std::uint8_t enough = 3;
    /// Frames that circulate together and were sent late at the same moment come back within this time.
    static constexpr Duration come_together = std::chrono::milliseconds{100};
    /// The maximum wait of states that may circulate: shorter than the age limit of sticks. Commands wait for RingWatch::patience.
    static constexpr Duration max_state_wait = std::chrono::milliseconds{150};

    enum class Fate : std::uint8_t {
        passes,
        waits,       // for Judgement::wait; then it is judged again, with Said::waited, and passes if it would have to wait again
        withheld,    // sent with the next one of the same bytes; when none comes, take_lost() counts it
        ends,        // it is a returned copy, to be dropped
    };
    struct Judgement {
        Fate fate = Fate::passes;
        bool probe = false;          // a probe, rings().ask(), should leave by the channel first
        std::uint32_t copies = 1;    // how often it is to be sent: includes those withheld before
        bool elsewhere = false;      // it ends, but may come from a device on two links, and not be a copy of ours
        Duration wait{};
        std::uint32_t repeats = 0;    // if the channel brings more copies while it waits, the wait is over
    };

    /// Opens a new channel of `link`, which leads to the same place as the links of its `group` (0: none). What was sent to an earlier
    /// channel with its number does not count. `probed`: a probe may leave by it.
    void open(ChannelId channel, LinkId link, std::uint8_t group, bool probed, TimePoint now) noexcept;
    void close(ChannelId channel) noexcept { rings_.close(channel); }
    /// The link is removed and its channels are closed: forgets what came by it and what was sent to it.
    void remove_link(LinkId link) noexcept;

    /// Judges a frame that came in by `from`. A copy is detected by its arrival time, even if it waited to be read.
    Judgement judge(const Said& said, ChannelId from, TimePoint now) noexcept {
        const TimePoint arrived = std::min(said.arrived, now);
        return arrived >= quiet_at_ ? Judgement{} : look_up(said, from, arrived, now);
    }

    /// Remembers a frame that came by `from` and passed; it was sent to, or may come back by, each of `channels`: Route::guarded.
    void remember(const Said& said, ChannelId from, ChannelSet channels, TimePoint now) noexcept;

    /// How many withheld frames of the channel are lost, as no next one came; each is counted once.
    std::uint32_t take_lost(ChannelId channel, TimePoint now) noexcept {
        Withheld& withheld = withheld_[index(channel)];
        if (withheld.frames == 0 || now < withheld.at + window_) return 0;
        return std::exchange(withheld.frames, 0);
    }

    RingWatch& rings() noexcept { return rings_; }
    const RingWatch& rings() const noexcept { return rings_; }

private:
    // Tests whether the frame comes back after a constant delay.
    struct Test {
        std::uint8_t number = 0;    // of finished tests
        std::uint8_t sent_late = 0;
        std::uint8_t steady = 0, strays = 0;
        std::uint16_t way = 0;    // delay from sending it to its return; ms
    };
    struct Sent {
        ChannelSet channels;
        ChannelSet returned;        // the channels by which it came again, also others
        std::uint32_t times = 0;    // how often it came again
        ChannelId from{};           // the channel by which it came first
        std::uint8_t withheld = 0;
        std::uint8_t owed = 0;               // copies that left by rings and may come back by `from`
        bool again : 1 = false;              // another channel brought it, while it was not known whether it is in a ring
        bool blindly : 1 = false;            // and no probe could be sent
        bool claimed : 1 = false;            // `from` is not the home of its source
        std::uint8_t anticipated : 5 = 0;    // how often `from` brought it before the home did
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

    // Links of one group lead to the same place.
    static constexpr std::uint8_t place(LinkId link, std::uint8_t group) noexcept {
        return static_cast<std::uint8_t>(group == 0 ? index(link) : max_links + group);
    }
    // The place of a channel that has no link.
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
