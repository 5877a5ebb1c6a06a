#include <gateway/ring_watch.hpp>

#include <algorithm>

namespace anogate {

void RingWatch::open(ChannelId channel, LinkId link, bool probed) noexcept {
    of(channel) = {};
    of(channel).link = link;
    rings_.erase(channel);
    if (probed) probed_.insert(channel);
    else probed_.erase(channel);
}

void RingWatch::close(ChannelId channel) noexcept {
    rings_.erase(channel);
    probed_.erase(channel);
}

void RingWatch::remove_link(LinkId link) noexcept {
    for (std::size_t i = 0; i < facts_.size(); ++i) {
        Facts& f = facts_[i];
        const bool made_of_it = f.ring_until != never && (f.ring.out == link || f.ring.back == link);
        if (f.link == link) f = {};
        else if (made_of_it) f.ring_since = f.ring_until = never;
        if (made_of_it) rings_.erase(static_cast<ChannelId>(i));
    }
}

bool RingWatch::is_clear(ChannelId channel, TimePoint now) noexcept {
    Facts& f = of(channel);
    if (!is_probed(channel)) roll(f, now);
    return now < f.clear_until || (f.asked_at != never && now - f.asked_at >= patience && now - f.asked_at < holds);
}

std::optional<RingWatch::Ring> RingWatch::ring(ChannelId channel, TimePoint now) const noexcept {
    const Facts& f = facts_[index(channel)];
    if (!rings_.contains(channel) || now >= f.ring_until) return std::nullopt;
    return f.ring;
}

ano::FrameView RingWatch::ask(ChannelId channel, TimePoint now) noexcept {
    Facts& f = of(channel);
    if (f.asked_at != never && !rings_.contains(channel) && now - f.asked_at >= patience && now - f.asked_at < holds)
        f.clear_until = now + holds;    // the previous probe did not come back
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

RingWatch::Probe RingWatch::take(ano::FrameView probe, ChannelId from, TimePoint now) noexcept {
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

void RingWatch::brought_back_ones_own(ChannelId channel, TimePoint now) noexcept {
    if (is_probed(channel)) return;
    const auto known = ring(channel, now);
    note(channel, known && known->certain ? *known : Ring{of(channel).link, of(channel).link, false}, now);
}

bool RingWatch::brought_back(ChannelId channel, bool first, TimePoint spread_at, TimePoint now) noexcept {
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

void RingWatch::spread(ChannelSet channels, TimePoint now) noexcept {
    for (const ChannelId channel : channels - probed_) {
        roll(of(channel), now);
        ++of(channel).spread;
    }
}

void RingWatch::told(ChannelSet channels, TimePoint now) noexcept {
    for (const ChannelId channel : channels - probed_) {
        roll(of(channel), now);
        ++of(channel).told;
    }
}

bool RingWatch::are_clear(ChannelSet channels, TimePoint now) noexcept {
    for (const ChannelId channel : channels)
        if (is_ring(channel, now) || !is_clear(channel, now)) return false;
    return true;
}

void RingWatch::note(ChannelId channel, Ring ring, TimePoint now) noexcept {
    Facts& f = of(channel);
    if (!is_ring(channel, now)) f.ring_since = now;
    f.ring = ring;
    f.ring_until = now + holds;
    f.clear_until = never;
    f.told = f.told_before = f.told_in_vain = 0;
    rings_.insert(channel);
}

void RingWatch::answered(ChannelId out, std::uint32_t question, ChannelId back, TimePoint now) noexcept {
    const auto& asked = of(out).questions;
    const bool known = question != 0 && std::find(asked.begin(), asked.end(), question) != asked.end();
    if (!is_probed(out) || !known || now - of(out).asked_at >= holds) return;
    const Ring ring{of(out).link, of(back).link};
    note(out, ring, now);
    note(back, ring, now);
}

void RingWatch::roll(Facts& f, TimePoint now) noexcept {
    const Duration age = now - f.period;
    if (age < ripe) return;
    const bool ripened = age >= 2 * ripe;    // then the frames spread in this period count as well
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

void RingWatch::weigh(Facts& f, std::uint32_t spread, std::uint32_t back, TimePoint now) noexcept {
    if (spread == 0) return;
    if (back * 2 <= spread) f.clear_until = now + holds;
    else if (spread > 1 && back * 4 >= spread * 3) f.clear_until = never;
}

}    // namespace anogate
