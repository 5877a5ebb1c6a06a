// Ends loops: frames that are sent on one channel and received again on another, as between two gateways joined by two links.
//
// - Equal bytes on a second channel may be from another device with the same id, from another host, or from a loop. So they pass,
//   and probes are sent ahead of them. Probes return only in a loop, and before the frame does. From then on, copies received on
//   the channels of that loop are dropped.
// - A loop that returns no probes is recognised by its traffic: more than `max_surplus` copies in a second on one channel, beyond
//   one for each frame of the first channel; or more than `max_same` of one frame.
// - Telemetry below these limits may circulate in an unknown loop. Commands may not, since each copy acts again. A command shows
//   a loop, however slow, by `max_again` more copies on other channels than one for each on the channel that began. The count
//   restarts after silence for `window`.
// - The first channel may repeat a frame without limit. In a known loop, each frame sent into it is expected back once.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/expiring_cache.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// The probe: 0xFB from 0xFE to 0xFF, so that bridges with strict filters still forward it. Every anogate recognises it.
inline constexpr std::uint8_t probe_id = 0xFB;
inline constexpr std::array<std::uint8_t, 4> probe_word{'R', 'i', 'n', 'g'};
inline constexpr std::size_t probe_data = probe_word.size() + 8 + 4 + 1;    // and: station, question, channel

constexpr bool is_probe(ano::FrameView frame) noexcept {
    if (frame.id() != probe_id || frame.source() != ano::address::host || frame.destination() != ano::address::broadcast)
        return false;
    const auto data = frame.data();
    return data.size() == probe_data && std::equal(probe_word.begin(), probe_word.end(), data.begin());
}

/// Constant time, no allocation after construction.
class LoopGuard {
public:
    using Duration = ano::Duration;
    using TimePoint = ano::TimePoint;

    /// How long a frame is stored after it was sent; a later copy is not recognised.
    static constexpr Duration window = std::chrono::seconds{2};
    /// The minimum time between two probes on a channel.
    static constexpr Duration spacing = std::chrono::seconds{1};
    /// If a probe did not return within this time, there is probably no loop.
    static constexpr Duration slowest = std::chrono::seconds{2};
    /// How long a loop is known after it was detected; less if its probes have not returned for `over_after`.
    static constexpr Duration holds = std::chrono::seconds{60}, over_after = std::chrono::seconds{5};
    static constexpr std::uint32_t max_surplus = 200, max_same = 1000;
    static constexpr std::uint8_t max_again = 100;

    /// `station` must be different in every gateway.
    explicit LoopGuard(std::uint64_t station = 1, std::size_t capacity = 16 * 1024)
        : station_{station}, sent_{window, capacity} {}

    /// Opens a new channel of `link`, which leads to the same place as the links of its `group` (0: none). Frames sent to an
    /// earlier channel with its number do not count. `probed`: probes may be sent on it.
    void open(ChannelId channel, LinkId link, std::uint8_t group, bool probed, TimePoint now) noexcept;
    void close(ChannelId channel) noexcept;

    struct Arrival {
        std::uint64_t key;    // frame_key()
        ChannelId from;
        TimePoint at;            // earlier than now if it waited to be read
        bool at_home = false;    // of a device whose route leads to `from`
        bool acts = false;       // each time it arrives, as a command does and sticks do not
    };
    struct Judgement {
        bool looped = false;       // drop it
        bool suspect = false;      // it passes; probes should be sent ahead of it on the same channels
        bool undecided = false;    // a copy, and a probe may still show a loop: no address is learned from it
        ChannelSet ask{};          // probes should be sent on these channels as well
    };
    Judgement judge(const Arrival& arrival, TimePoint now) noexcept {
        return arrival.at >= quiet_at_ ? Judgement{} : look_up(arrival, now);
    }
    /// Stores a frame that passed. It may be received again on each of `channels`: Route::guarded. `from` may be `ourselves`.
    /// `replayed`: it is from a recording, so its device is elsewhere.
    void remember(const Arrival& arrival, ChannelSet channels, TimePoint now, bool replayed = false) noexcept;

    /// The channels on which probes may be sent: our own, and those of other gateways that are forwarded.
    ChannelSet probed() const noexcept { return probed_; }
    bool is_due(ChannelId channel, TimePoint now) const noexcept {
        const State& state = of(channel);
        return probed_.contains(channel) && (state.asked_at == never || now - state.asked_at >= spacing);
    }
    /// The next probe, to be sent on the channel now. Valid until the next call.
    ano::FrameView ask(ChannelId channel, TimePoint now) noexcept;
    /// Processes a probe received on `from`. True: it is from another gateway and new, so it must be forwarded.
    bool accept_probe(ano::FrameView probe, ChannelId from, TimePoint now) noexcept;

    /// The links of a loop: frames sent on `out` return on `back`. Both are the same if only its traffic has shown it.
    struct Loop {
        LinkId out{}, back{};
        bool operator==(const Loop&) const = default;
    };
    /// The known loop that contains the channel.
    std::optional<Loop> loop(ChannelId channel, TimePoint now) const noexcept;
    bool is_loop(ChannelId channel, TimePoint now) noexcept {
        if (!loops_.contains(channel)) return false;
        if (is_known(of(channel), now)) return true;
        loops_.erase(channel);
        return false;
    }

private:
    static constexpr TimePoint never = TimePoint::min();
    struct Sent {
        ChannelSet channels;     // to which it was sent
        ChannelSet copied_by;    // other channels than `from` on which it was received
        ChannelId from{};        // the channel on which it was received first
        std::int8_t owed = 0;    // copies that were sent into known loops and were not received back
        bool replayed = false;
        ChannelId begun_by{};                       // the first channel after silence for `window`
        std::uint8_t again = 0;                     // frames that act: surplus copies on other channels since
        TimePoint from_at = never;                  // when it was last received on `from`
        TimePoint second = never;                   // start of the second in which the next two were counted
        std::uint32_t originals = 0, copies = 0;    // by `from`, by others
    };
    static constexpr int max_owed = 8, max_ahead = 3;    // ahead: more were received back than sent

    struct State {
        LinkId link{};
        std::uint8_t place = 0;
        TimePoint opened_at = never;
        TimePoint asked_at = never, unanswered_since = never;
        std::array<std::uint32_t, 8> questions{};    // the latest; in a slow loop one may return after the next was sent
        ChannelId out{}, back{};                     // of its loop
        bool by_traffic = false;                     // only traffic has shown the loop
        TimePoint loop_since = never, loop_until = never;
        TimePoint second = never;
        std::uint32_t surplus = 0;    // copies in that second
    };
    State& of(ChannelId channel) noexcept { return states_[index(channel)]; }
    const State& of(ChannelId channel) const noexcept { return states_[index(channel)]; }

    Judgement look_up(const Arrival& arrival, TimePoint now) noexcept;
    bool comes_back(Sent& known, const Arrival& arrival, TimePoint now) noexcept;
    Judgement judge_copy(Sent& known, const Arrival& arrival, TimePoint now) noexcept;
    bool storms(Sent& known, ChannelId from, TimePoint now) noexcept;
    bool is_circulating(Sent& known, ChannelId from, TimePoint now) noexcept;
    void note(ChannelId channel, ChannelId out, ChannelId back, bool by_traffic, TimePoint now) noexcept;
    void answered(ChannelId out, std::uint32_t question, ChannelId back, TimePoint now) noexcept;
    bool is_known(const State& state, TimePoint now) const noexcept;
    bool may_be_answered(ChannelId channel, TimePoint now) const noexcept;
    bool same_place(ChannelId a, ChannelId b) const noexcept { return of(a).place == of(b).place; }

    std::uint64_t station_;
    ExpiringCache<Sent> sent_;
    TimePoint quiet_at_ = never;
    std::uint32_t questions_ = 0;
    ChannelSet probed_, loops_;                           // loops_: channels recently known to be in a loop
    std::array<State, max_channels + 1> states_ = [] {    // each in a separate place until it is opened; the last: ourselves
        std::array<State, max_channels + 1> all;
        for (std::size_t i = 0; i < all.size(); ++i) all[i].place = static_cast<std::uint8_t>(2 * max_links + 1 + i);
        return all;
    }();
    struct Nothing {};
    ExpiringCache<Nothing> others_{std::chrono::seconds{10}, 1024};    // probes of other gateways
    std::array<std::uint8_t, ano::overhead + probe_data> probe_{};
};

}    // namespace anogate
