#include <gateway/loop_guard.hpp>

#include <bit>
#include <cstdlib>

namespace anogate {

void LoopGuard::open(ChannelId channel, LinkId link, std::uint8_t group, bool probed, TimePoint now) noexcept {
    link_of_[index(channel)] = link;
    place_of_[index(channel)] = place(link, group);
    opened_at_[index(channel)] = now;
    withheld_[index(channel)] = {};
    rings_.open(channel, link, probed);
}

void LoopGuard::remove_link(LinkId link) noexcept {
    ChannelSet gone;
    for (std::size_t i = 0; i < max_channels; ++i) {
        if (link_of_[i] != link) continue;
        gone.insert(static_cast<ChannelId>(i));
        place_of_[i] = place_of_its_own(i);
        withheld_[i] = {};
    }
    sent_.keep_if([gone](std::uint64_t, Sent& sent) {
        sent.channels -= gone;
        sent.returned -= gone;
        return !gone.contains(sent.from);
    });
    rings_.remove_link(link);
}

LoopGuard::Judgement LoopGuard::look_up(const Said& said, ChannelId from, TimePoint arrived, TimePoint now) noexcept {
    Sent* known = sent_.find(said.key, arrived);
    if (!known) return {};
    const Judgement judgement = judge(*known, said, from, now);
    if (judgement.fate == Fate::withheld || now < known->withheld_until) {    // its next repeat is awaited for another window
        sent_.put(said.key, *known, now);
        quiet_at_ = now + window_;
    }
    return judgement;
}

void LoopGuard::remember(const Said& said, ChannelId from, ChannelSet channels, TimePoint now) noexcept {
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
    } else if (said.replayed) {
        sent.replayed = true;
    } else if (said.by_host) {
        rings_.spread(channels, now);
    }
    if (!said.by_host && !said.replayed && said.to_all) rings_.told(channels, now);
    if (const ChannelSet back = (channels - from) & rings_.rings(); !back.empty())
        sent.owed = static_cast<std::uint8_t>(std::min<std::size_t>(sent.owed + back.size(), max_channels));
    if (sent.claimed && claimed && sent.anticipated < max_anticipated) ++sent.anticipated;
    sent_.put(said.key, sent, now);
    quiet_at_ = now + window_;
}

LoopGuard::Judgement LoopGuard::judge(Sent& known, const Said& said, ChannelId from, TimePoint now) noexcept {
    const TimePoint sent_at = sent_.put_at(said.key);
    if (known.from == from) return repeated(known, said, from, sent_at, now);
    if (sent_at <= opened_at_[index(from)]) return {};
    const bool went = known.channels.contains(from);
    if (!went && same_place(known.from, from)) return {};    // a sender with a new port
    if (said.by_host) return said_again(known, said, from, sent_at, now);
    if (known.replayed) return said_beside_replay(from, sent_at, now);
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

// The frame came again by the channel that brought it first.
LoopGuard::Judgement LoopGuard::repeated(Sent& known, const Said& said, ChannelId from, TimePoint sent_at,
                                         TimePoint now) noexcept {
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

// The frame of a host came by another channel: another host may have sent it.
LoopGuard::Judgement LoopGuard::said_again(Sent& known, const Said& said, ChannelId from, TimePoint sent_at,
                                           TimePoint now) noexcept {
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

// A frame of a replay came again: from its device, which is connected as well, or by a ring.
LoopGuard::Judgement LoopGuard::said_beside_replay(ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
    if (rings_.is_ring(from, now) || rings_.brought_back(from, false, sent_at, now))
        return {Fate::ends, rings_.is_due(from, now, RingWatch::calm)};
    return {Fate::passes, rings_.is_due(from, now, knows(from, now) ? RingWatch::calm : RingWatch::spacing)};
}

// It is not known whether there is a ring, and no probe can be sent here. The frame waits only if a probe has just left by another
// channel, by which the frame may have left too.
LoopGuard::Judgement LoopGuard::blindly(const Said& said, TimePoint now) const noexcept {
    if (!said.command || said.waited || !rings_.is_asking(now)) return {Fate::ends};
    return {.fate = Fate::waits, .wait = RingWatch::patience};
}

// The frame passes, unless it was repeated so often that it is withheld to see whether it still comes.
LoopGuard::Judgement LoopGuard::paced(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
    known.times += !said.waited;
    if (const Judgement judgement = tested(known, said, from, sent_at, now); judgement.fate != Fate::passes) return judgement;
    Withheld& withheld = withheld_[index(known.from)];
    const std::uint32_t turns = known.times / repeats;
    if (turns > 0 && !said.waited && known.withheld < max_withheld_frames) {
        const std::uint32_t max_in_row = std::bit_floor(turns);
        if (known.withheld == 0) withheld.since = now;
        const bool in_time = now - withheld.since < (said.state ? max_state_withheld : max_withheld);
        if (in_time && known.times - max_in_row * repeats < max_in_row) {
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

// After a delayed send, a sender's next frame comes by its own clock; in a ring no frame comes before, and the next always comes
// after the same delay.
LoopGuard::Judgement LoopGuard::tested(Sent& known, const Said& said, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
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
            // If several copies circulate, the delay is not steady.
            const std::uint32_t turns = (known.times / first_test) >> test.number;
            if (!said.command || test.number == max_tests || turns < (steady ? 1u : 2u)) return {};
        } else if (steady) {
            if (++test.steady >= enough) return came_round(known, from, now);
        } else {
            const bool ended = test.steady == enough;    // it was taken for a ring, but frames still come
            test.steady = 0;
            if (ended || ++test.strays > 1) return end_test(known), Judgement{};
        }
        known.withheld_until = now + tested_for[test.sent_late++ % tested_for.size()];
    }
    return {.fate = Fate::waits, .wait = known.withheld_until - now, .repeats = std::max(known.times / first_test, 1u)};
}

// Other frames that circulate in the same ring end as well.
LoopGuard::Judgement LoopGuard::came_round(Sent& known, ChannelId from, TimePoint now) noexcept {
    known.test.steady = enough;
    if (known.from != from) rings_.came_round(from, now);
    return {Fate::ends};
}

void LoopGuard::end_test(Sent& known) noexcept {
    known.test = {.number = static_cast<std::uint8_t>(known.test.number + 1), .way = known.test.way};
    known.withheld_until = TimePoint::min();
}

// Only the newest state matters, so states wait only in a fast ring, and for a short time.
LoopGuard::Judgement LoopGuard::waiting(const Said& said, TimePoint sent_at, bool probe, TimePoint now) noexcept {
    const bool waits = !said.state || now - sent_at < faster_than_senders;
    return {
        .fate = waits ? Fate::waits : Fate::passes, .probe = probe, .wait = said.state ? max_state_wait : RingWatch::patience};
}

// Whether `from` may be the other end of a ring whose bridges do not forward frames of devices: there only a probe by the other end
// shows the ring.
bool LoopGuard::may_be_its_other_end(const Sent& known, ChannelId from, TimePoint sent_at, TimePoint now) noexcept {
    if (rings_.is_probed(from) || known.times == 0) return false;
    return rings_.is_asking(now) || (now - sent_at < RingWatch::by_hand && !rings_.are_clear(known.channels - from, now));
}

// There is no ring by which the frame can have come.
bool LoopGuard::is_clear(const Sent& known, ChannelId from, TimePoint now) noexcept {
    return rings_.is_clear(from, now) || (!rings_.is_probed(from) && rings_.are_clear(known.channels - from, now));
}

}    // namespace anogate
