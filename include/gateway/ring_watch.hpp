// Finds out which channels bring back frames that were sent by others: by a probe of our own that comes back only in a ring, and
// where no probe may be sent, by the frames that come back.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/expiring_cache.hpp>
#include <gateway/ids.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// The probe: 0xFB from 0xFE to 0xFF, so that bridges which forward little else forward it. Every anogate recognises it.
inline constexpr std::uint8_t probe_id = 0xFB;
inline constexpr std::array<std::uint8_t, 4> probe_word{'R', 'i', 'n', 'g'};
inline constexpr std::size_t probe_data = probe_word.size() + 8 + 4 + 1;    // and: station, question, channel

constexpr bool is_probe(ano::FrameView frame) noexcept {
    if (frame.id() != probe_id || frame.source() != ano::address::host || frame.destination() != ano::address::broadcast)
        return false;
    const auto data = frame.data();
    if (data.size() != probe_data) return false;
    for (std::size_t i = 0; i < probe_word.size(); ++i)
        if (data[i] != probe_word[i]) return false;
    return true;
}

/// What is known of the channels. Constant time, no allocation after construction.
class RingWatch {
public:
    using Duration = ano::Duration;
    using TimePoint = ano::TimePoint;

    /// If the probe has not come back this long after it left, there is taken to be no ring; one that comes back later still shows a
    /// ring. In a ring that takes no longer, a frame passes at most twice.
    static constexpr Duration patience = std::chrono::milliseconds{600};
    /// During `slowest` after the first probe, what is repeated faster than `by_hand` waits all the same: a ring may be fast one way
    /// and slow the other.
    static constexpr Duration slowest = std::chrono::seconds{2}, by_hand = std::chrono::milliseconds{100};
    /// Between two probes by one channel: `spacing`, or `calm` where the result is known.
    static constexpr Duration spacing = std::chrono::seconds{1}, calm = std::chrono::seconds{10};
    /// How long a result, ring or no ring, is valid.
    static constexpr Duration holds = std::chrono::seconds{60};
    /// No sender repeats the frames of others this often in a second: it is a ring, whatever the probe showed.
    static constexpr std::uint32_t storm = 1000;
    /// A frame sent by a channel that may not be probed is taken not to come back if it has not within this time.
    static constexpr Duration ripe = std::chrono::seconds{1};
    /// This many broadcasts of devices show that there is no ring, when none of them comes back.
    static constexpr std::uint32_t telling = 8;

    /// `station` must be different in every gateway.
    explicit RingWatch(std::uint64_t station = 1) : station_{station} {}

    /// Opens a new channel of `link`. `probed`: a probe may leave by it.
    void open(ChannelId channel, LinkId link, bool probed) noexcept;
    void close(ChannelId channel) noexcept;
    /// The link is removed and its channels are closed: forgets rings with it.
    void remove_link(LinkId link) noexcept;

    /// The channels by which probes may leave, our own and those of other gateways that are forwarded.
    ChannelSet probed() const noexcept { return probed_; }
    bool is_probed(ChannelId channel) const noexcept { return probed_.contains(channel); }
    /// The channels that were known to be in a ring lately.
    ChannelSet rings() const noexcept { return rings_; }
    bool is_ring(ChannelId channel, TimePoint now) noexcept {
        if (!rings_.contains(channel)) return false;
        if (now < of(channel).ring_until) return true;
        rings_.erase(channel);
        return false;
    }
    /// Since when the channel is known to be in a ring; only if is_ring().
    TimePoint ring_since(ChannelId channel) const noexcept { return facts_[index(channel)].ring_since; }
    /// Known not to be in a ring: the probe did not come back, or where no probe may be sent, half of what hosts sent or all that devices
    /// sent did not.
    bool is_clear(ChannelId channel, TimePoint now) noexcept;
    /// The first probe left so recently that in a slow ring it may not have come back yet.
    bool is_new(ChannelId channel, TimePoint now) const noexcept {
        const Facts& f = facts_[index(channel)];
        return f.first_asked_at != never && now - f.first_asked_at < slowest;
    }
    /// A probe has left that may still come back.
    bool is_asking(TimePoint now) const noexcept { return now < last_asked_at_ + patience; }

    /// The links of a ring: frames that leave by `out` come back by `back`; both are the same where the probe can't show it.
    struct Ring {
        LinkId out{}, back{};
        bool certain = true;    // false: may also be a device on two links
    };
    std::optional<Ring> ring(ChannelId channel, TimePoint now) const noexcept;

    /// Whether a probe should leave by the channel: the last one is at least `since` ago, which is `spacing` or more.
    bool is_due(ChannelId channel, TimePoint now, Duration since = spacing) const noexcept {
        const Facts& f = facts_[index(channel)];
        return is_probed(channel) && (f.asked_at == never || now - f.asked_at >= since);
    }
    /// The next probe, to leave by the channel now. Valid until the next call.
    ano::FrameView ask(ChannelId channel, TimePoint now) noexcept;
    /// What to do with a probe, see is_probe(), that came in by `from`.
    enum class Probe : std::uint8_t {
        ours,     // it came back: the channel that it left by and `from` are in a ring
        known,    // seen before: it is dropped
        news,     // another gateway's: it is forwarded, once
    };
    Probe take(ano::FrameView probe, ChannelId from, TimePoint now) noexcept;

    /// The channel brought back a device's frame that had been sent out by it. Where no probe may be sent, this shows a ring; a device
    /// with two cables looks the same.
    void brought_back_ones_own(ChannelId channel, TimePoint now) noexcept;
    /// Whatever the probe showed, frames sent by the channel come back by it.
    void came_round(ChannelId channel, TimePoint now) noexcept { note(channel, {of(channel).link, of(channel).link}, now); }
    /// The channel brought a frame that a host had sent before, and that others may send as well; `first`: for the first time since it
    /// was spread. True: this happens so often that it is a ring.
    bool brought_back(ChannelId channel, bool first, TimePoint spread_at, TimePoint now) noexcept;
    /// A frame of a host leaves by `channels`, for the first time.
    void spread(ChannelSet channels, TimePoint now) noexcept;
    /// A broadcast of a device leaves by `channels`.
    void told(ChannelSet channels, TimePoint now) noexcept;
    /// None of them is in a ring, see is_clear().
    bool are_clear(ChannelSet channels, TimePoint now) noexcept;

private:
    static constexpr TimePoint never = TimePoint::min();
    struct Facts {
        LinkId link{};
        TimePoint ring_since = never, ring_until = never, clear_until = never, asked_at = never;
        TimePoint first_asked_at = never;
        std::array<std::uint32_t, 8> questions{};    // the latest; in a slow ring one may come back after the next has left
        Ring ring{};
        TimePoint second{};
        std::uint32_t in_second = 0;
        // Frames of hosts, spread by it and brought back, in this period and in the one before; where no probe may be sent.
        TimePoint period{};
        std::uint32_t spread = 0, back = 0, spread_before = 0, back_before = 0;
        std::uint32_t told = 0, told_before = 0,
                      told_in_vain = 0;    // the same for devices, and how many did not come back
    };
    Facts& of(ChannelId channel) noexcept { return facts_[index(channel)]; }

    void note(ChannelId channel, Ring ring, TimePoint now) noexcept;
    void answered(ChannelId out, std::uint32_t question, ChannelId back, TimePoint now) noexcept;
    static void roll(Facts& f, TimePoint now) noexcept;
    static void weigh(Facts& f, std::uint32_t spread, std::uint32_t back, TimePoint now) noexcept;

    std::uint64_t station_;
    std::uint32_t questions_ = 0;
    TimePoint last_asked_at_ = never;
    ChannelSet probed_, rings_;
    std::array<Facts, max_channels> facts_{};
    struct Nothing {};
    ExpiringCache<Nothing> seen_{calm, 1024};
    std::array<std::uint8_t, ano::overhead + probe_data> probe_{};
};

}    // namespace anogate
