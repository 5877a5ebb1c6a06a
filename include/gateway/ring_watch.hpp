// Which channels bring back what went out by others: a question of our own that only a ring answers, and where it may not go,
// what can be told without it.
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

/// The probe: 0xFB from 0xFE to 0xFF, so that bridges which forward nothing else forward it. Every anogate knows it.
inline constexpr std::uint8_t probe_id = 0xFB;
inline constexpr std::array<std::uint8_t, 4> probe_word{'R', 'i', 'n', 'g'};
inline constexpr std::size_t probe_data = probe_word.size() + 8 + 4 + 1;    // then: who asks, which question, by which channel

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

    /// Where the probe was not answered so long after it left, no ring is; one that comes back later tells all the same. So
    /// slow may the way round be for a frame to pass no more than twice.
    static constexpr Duration patience = std::chrono::milliseconds{600};
    /// For so long what is said faster than by hand waits all the same: a ring may be fast one way and slow the other.
    static constexpr Duration slowest = std::chrono::seconds{2}, by_hand = std::chrono::milliseconds{100};
    /// Between two probes by one channel, and where the answer is known.
    static constexpr Duration spacing = std::chrono::seconds{1}, calm = std::chrono::seconds{10};
    /// How long a verdict holds: a ring, or none.
    static constexpr Duration holds = std::chrono::seconds{60};
    /// So often in a second nobody says what others said: whatever it is made of, it is a ring.
    static constexpr std::uint32_t storm = 1000;
    /// Of what is spread by a channel that may not be probed, what did not come back within this time does not come back.
    static constexpr Duration ripe = std::chrono::seconds{1};
    /// So many broadcasts of devices tell that no ring is there, when none of them comes back.
    static constexpr std::uint32_t telling = 8;

    /// `station` is a number that no other gateway has.
    explicit RingWatch(std::uint64_t station = 1) : station_{station} {}

    /// The channel is new, one of `link`. `probed`: a probe may leave by it.
    void open(ChannelId channel, LinkId link, bool probed) noexcept;
    void close(ChannelId channel) noexcept;
    /// The link is no more, its channels are closed: no ring is made of it.
    void remove_link(LinkId link) noexcept;

    /// By which a probe may leave: ours, and those of others that go on.
    ChannelSet probed() const noexcept { return probed_; }
    bool is_probed(ChannelId channel) const noexcept { return probed_.contains(channel); }
    /// Those that were known to be a ring lately.
    ChannelSet rings() const noexcept { return rings_; }
    bool is_ring(ChannelId channel, TimePoint now) noexcept {
        if (!rings_.contains(channel)) return false;
        if (now < of(channel).ring_until) return true;
        rings_.erase(channel);
        return false;
    }
    /// Since when the channel is known to be a ring; for one that is.
    TimePoint ring_since(ChannelId channel) const noexcept { return facts_[index(channel)].ring_since; }
    /// It is known to be none: the probe stayed away, or where no probe may go, half of what hosts said or all that devices did.
    bool is_clear(ChannelId channel, TimePoint now) noexcept;
    /// It was asked for the first time so lately that a slow ring may not have answered yet.
    bool is_new(ChannelId channel, TimePoint now) const noexcept {
        const Facts& f = facts_[index(channel)];
        return f.first_asked_at != never && now - f.first_asked_at < slowest;
    }
    /// A probe is out that may yet be answered.
    bool is_asking(TimePoint now) const noexcept { return now < last_asked_at_ + patience; }

    /// What a ring is made of: what leaves by `out` comes back by `back`; the same where the probe can't tell.
    struct Ring {
        LinkId out{}, back{};
        bool certain = true;    // or a device on two links
    };
    std::optional<Ring> ring(ChannelId channel, TimePoint now) const noexcept;

    /// A probe should leave by the channel, for the last is `since` ago; spacing at least.
    bool is_due(ChannelId channel, TimePoint now, Duration since = spacing) const noexcept {
        const Facts& f = facts_[index(channel)];
        return is_probed(channel) && (f.asked_at == never || now - f.asked_at >= since);
    }
    /// The next probe to leave by the channel, now. Valid until the next call.
    ano::FrameView ask(ChannelId channel, TimePoint now) noexcept;
    /// What becomes of a probe, is_probe(), that came in by `from`.
    enum class Probe : std::uint8_t {
        ours,     // answered: the channel that it left by and `from` are a ring
        known,    // goes no further
        news,     // another gateway's: it goes on, once
    };
    Probe take(ano::FrameView probe, ChannelId from, TimePoint now) noexcept;

    /// It brought back what its one sender had said and what had gone out by it. Where no probe may go, that is what tells a
    /// ring; a device with two cables looks the same.
    void brought_back_ones_own(ChannelId channel, TimePoint now) noexcept;
    /// Whatever the probe said, what goes out comes round by it.
    void came_round(ChannelId channel, TimePoint now) noexcept { note(channel, {of(channel).link, of(channel).link}, now); }
    /// It brought what a host had said before and what others may say as well; `first`: since that was spread. True: this
    /// often only a ring does.
    bool brought_back(ChannelId channel, bool first, TimePoint spread_at, TimePoint now) noexcept;
    /// What a host said leaves by `channels`, for the first time.
    void spread(ChannelSet channels, TimePoint now) noexcept;
    /// What a device said to everybody leaves by `channels`.
    void told(ChannelSet channels, TimePoint now) noexcept;
    /// Every one of them is known to be none.
    bool are_clear(ChannelSet channels, TimePoint now) noexcept;

private:
    static constexpr TimePoint never = TimePoint::min();
    struct Facts {
        LinkId link{};
        TimePoint ring_since = never, ring_until = never, clear_until = never, asked_at = never;
        TimePoint first_asked_at = never;
        std::array<std::uint32_t, 8> questions{};    // the latest; a slow ring answers when the next is out
        Ring ring{};
        TimePoint second{};
        std::uint32_t in_second = 0;
        // What hosts said, spread by it and brought back, in this period and in the one before; where no probe may go.
        TimePoint period{};
        std::uint32_t spread = 0, back = 0, spread_before = 0, back_before = 0;
        std::uint32_t told = 0, told_before = 0,
                      told_in_vain = 0;    // what devices said, as well, and all that did not come back
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
