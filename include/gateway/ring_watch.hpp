// Which channels bring back what went out by others: a question of our own that only a ring answers, and where it may not go,
// what can be told without it.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/ids.hpp>
#include <gateway/recent.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

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
    void open(ChannelId channel, LinkId link, bool probed) noexcept {
        of(channel) = {};
        of(channel).link = link;
        rings_.erase(channel);
        if (probed) probed_.insert(channel);
        else probed_.erase(channel);
    }
    void close(ChannelId channel) noexcept {
        rings_.erase(channel);
        probed_.erase(channel);
    }

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
    bool is_clear(ChannelId channel, TimePoint now) noexcept {
        Facts& f = of(channel);
        if (!is_probed(channel)) roll(f, now);
        return now < f.clear_until || (f.asked_at != never && now - f.asked_at >= patience && now - f.asked_at < holds);
    }
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
    std::optional<Ring> ring(ChannelId channel, TimePoint now) const noexcept {
        const Facts& f = facts_[index(channel)];
        if (!rings_.contains(channel) || now >= f.ring_until) return std::nullopt;
        return f.ring;
    }

    /// A probe should leave by the channel, for the last is `since` ago; spacing at least.
    bool is_due(ChannelId channel, TimePoint now, Duration since = spacing) const noexcept {
        const Facts& f = facts_[index(channel)];
        return is_probed(channel) && (f.asked_at == never || now - f.asked_at >= since);
    }
    /// The next probe to leave by the channel, now. Valid until the next call.
    ano::FrameView ask(ChannelId channel, TimePoint now) noexcept {
        Facts& f = of(channel);
        if (f.asked_at != never && !rings_.contains(channel) && now - f.asked_at >= patience && now - f.asked_at < holds)
            f.clear_until = now + holds;    // the one before was not answered
        if (now >= f.clear_until) last_asked_at_ = now;
        if (f.asked_at == never || now - f.asked_at >= holds) f.first_asked_at = now;
        f.asked_at = now;
        std::move_backward(f.questions.begin(), f.questions.end() - 1, f.questions.end());
        f.questions[0] = ++questions_;
        std::array<std::uint8_t, probe_data> data{};
        std::copy(probe_word.begin(), probe_word.end(), data.begin());
        for (unsigned i = 0; i < 8; ++i) data[4 + i] = static_cast<std::uint8_t>(station_ >> 8 * i);
        for (unsigned i = 0; i < 4; ++i) data[12 + i] = static_cast<std::uint8_t>(f.questions[0] >> 8 * i);
        data[16] = static_cast<std::uint8_t>(channel);
        ano::encode(probe_, ano::address::host, ano::address::broadcast, probe_id, data);
        return ano::FrameView{probe_};
    }
    /// What becomes of a probe, is_probe(), that came in by `from`.
    enum class Probe : std::uint8_t {
        ours,     // answered: the channel that it left by and `from` are a ring
        known,    // goes no further
        news,     // another gateway's: it goes on, once
    };
    Probe take(ano::FrameView probe, ChannelId from, TimePoint now) noexcept {
        const auto data = probe.data();
        std::uint64_t station = 0;
        std::uint32_t question = 0;
        for (unsigned i = 0; i < 8; ++i) station |= std::uint64_t{data[4 + i]} << 8 * i;
        for (unsigned i = 0; i < 4; ++i) question |= std::uint32_t{data[12 + i]} << 8 * i;
        if (station == station_) {
            answered(static_cast<ChannelId>(data[16] % max_channels), question, from, now);
            return Probe::ours;
        }
        const std::uint64_t key = (station ^ std::uint64_t{data[16]} << 56) + std::uint64_t{question} * 0x9E3779B97F4A7C15u;
        if (seen_.find(key, now)) return Probe::known;
        seen_.put(key, {}, now);
        return Probe::news;
    }

    /// It brought back what its one sender had said and what had gone out by it. Where no probe may go, that is what tells a
    /// ring; a device with two cables looks the same.
    void brought_back_ones_own(ChannelId channel, TimePoint now) noexcept {
        if (is_probed(channel)) return;
        const auto known = ring(channel, now);
        note(channel, known && known->certain ? *known : Ring{of(channel).link, of(channel).link, false}, now);
    }
    /// Whatever the probe said, what goes out comes round by it.
    void came_round(ChannelId channel, TimePoint now) noexcept { note(channel, {of(channel).link, of(channel).link}, now); }
    /// It brought what a host had said before and what others may say as well; `first`: since that was spread. True: this
    /// often only a ring does.
    bool brought_back(ChannelId channel, bool first, TimePoint spread_at, TimePoint now) noexcept {
        Facts& f = of(channel);
        if (now - f.second >= std::chrono::seconds{1}) {
            f.second = now;
            f.in_second = 0;
        }
        if (!is_probed(channel)) {
            roll(f, now);
            if (first) ++(spread_at < f.period ? f.back_before : f.back);
        }
        if (++f.in_second <= storm) return false;
        came_round(channel, now);
        return true;
    }
    /// What a host said leaves by `channels`, for the first time.
    void spread(ChannelSet channels, TimePoint now) noexcept {
        for (const ChannelId channel : channels - probed_) {
            roll(of(channel), now);
            ++of(channel).spread;
        }
    }
    /// What a device said to everybody leaves by `channels`.
    void told(ChannelSet channels, TimePoint now) noexcept {
        for (const ChannelId channel : channels - probed_) {
            roll(of(channel), now);
            ++of(channel).told;
        }
    }
    /// Every one of them is known to be none.
    bool are_clear(ChannelSet channels, TimePoint now) noexcept {
        for (const ChannelId channel : channels)
            if (is_ring(channel, now) || !is_clear(channel, now)) return false;
        return true;
    }

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

    void note(ChannelId channel, Ring ring, TimePoint now) noexcept {
        Facts& f = of(channel);
        if (!is_ring(channel, now)) f.ring_since = now;
        f.ring = ring;
        f.ring_until = now + holds;
        f.clear_until = never;
        f.told = f.told_before = f.told_in_vain = 0;
        rings_.insert(channel);
    }
    void answered(ChannelId out, std::uint32_t question, ChannelId back, TimePoint now) noexcept {
        const auto& asked = of(out).questions;
        const bool known = question != 0 && std::find(asked.begin(), asked.end(), question) != asked.end();
        if (!is_probed(out) || !known || now - of(out).asked_at >= holds) return;
        const Ring ring{of(out).link, of(back).link};
        note(out, ring, now);
        note(back, ring, now);
    }
    static void roll(Facts& f, TimePoint now) noexcept {
        const Duration age = now - f.period;
        if (age < ripe) return;
        const bool ripened = age >= 2 * ripe;    // what was spread in this period as well
        weigh(f, f.spread_before, f.back_before, now);
        if (ripened) weigh(f, f.spread, f.back, now);
        const std::uint32_t in_vain = f.told_before + (ripened ? f.told : 0);
        f.told_in_vain = std::min(f.told_in_vain + in_vain, telling);
        if (in_vain > 0 && f.told_in_vain == telling) f.clear_until = now + holds;
        f.told_before = ripened ? 0 : f.told;
        f.told = 0;
        f.spread_before = ripened ? 0 : f.spread;
        f.back_before = ripened ? 0 : f.back;
        f.spread = f.back = 0;
        f.period = now;
    }
    static void weigh(Facts& f, std::uint32_t spread, std::uint32_t back, TimePoint now) noexcept {
        if (spread == 0) return;
        if (back * 2 <= spread) f.clear_until = now + holds;
        else if (spread > 1 && back * 4 >= spread * 3) f.clear_until = never;
    }

    std::uint64_t station_;
    std::uint32_t questions_ = 0;
    TimePoint last_asked_at_ = never;
    ChannelSet probed_, rings_;
    std::array<Facts, max_channels> facts_{};
    struct Nothing {};
    Recent<Nothing> seen_{calm, 1024};
    std::array<std::uint8_t, ano::overhead + probe_data> probe_{};
};

}    // namespace anogate
