#include <gateway/loop_guard.hpp>

namespace anogate {
namespace {

// Begins the next second of a count, if the last one is over.
bool begins_second(LoopGuard::TimePoint& second, LoopGuard::TimePoint now) noexcept {
    if (second != LoopGuard::TimePoint::min() && now - second < std::chrono::seconds{1}) return false;
    second = now;
    return true;
}

}    // namespace

void LoopGuard::open(ChannelId channel, LinkId link, std::uint8_t group, bool probed, TimePoint now) noexcept {
    close(channel);
    State& state = of(channel);
    state = {};
    state.link = link;
    state.place = static_cast<std::uint8_t>(group == 0 ? index(link) : max_links + group);
    state.opened_at = now;
    if (probed) probed_.insert(channel);
}

// Ends the loops that contained the channel.
void LoopGuard::close(ChannelId channel) noexcept {
    probed_.erase(channel);
    for (const ChannelId other : loops_)
        if (other == channel || of(other).out == channel || of(other).back == channel) loops_.erase(other);
}

LoopGuard::Judgement LoopGuard::look_up(const Arrival& arrival, TimePoint now) noexcept {
    Sent* const known = sent_.find(arrival.key, arrival.at);
    if (!known || sent_.stored_at(arrival.key) <= of(arrival.from).opened_at) return {};
    const bool in_loop = is_loop(arrival.from, now);
    if (arrival.acts && is_circulating(*known, arrival.from, now)) return {.looped = true};
    if (known->from == arrival.from) {
        if (!in_loop) return {.suspect = known->originals > max_surplus};    // a loop with one direction looks like this
        if (!comes_back(*known, arrival, now)) return {};
        return {.looped = true, .ask = of(arrival.from).out};
    }
    if (!known->channels.contains(arrival.from) && same_place(known->from, arrival.from))
        return {};    // a sender with a new port
    const ChannelSet sent_into = known->channels & loops_;
    if (!in_loop || sent_into.empty()) return judge_copy(*known, arrival, now);
    if (loops_.size() <= 2)    // the opposite direction: where both meet, neither returns
        known->owed = static_cast<std::int8_t>(std::max(known->owed - 1, -max_ahead));
    return {.looped = true, .ask = of(arrival.from).out};
}

// Whether a frame returned on the channel on which it was received first. It is expected as often as it was sent into the loop.
bool LoopGuard::comes_back(Sent& known, const Arrival& arrival, TimePoint now) noexcept {
    if (sent_.stored_at(arrival.key) <= of(arrival.from).loop_since && !(known.channels & loops_).empty()) {
        known.owed = static_cast<std::int8_t>(std::max<int>(known.owed, 1));    // it was sent before the loop was known
        sent_.put(arrival.key, known, now);
    }
    if (known.owed <= 0) return false;
    --known.owed;
    return true;
}

// A copy through no known loop: from another sender, or through a loop that is not known yet.
LoopGuard::Judgement LoopGuard::judge_copy(Sent& known, const Arrival& arrival, TimePoint now) noexcept {
    const bool has_moved = arrival.at - known.from_at >= window;    // or the other sender is silent
    if (has_moved || arrival.at_home) {                             // the first sender may have used this device's address
        known.from = arrival.from;
        known.copied_by.erase(arrival.from);
        known.copies = 0;
        known.owed = 0;
        if (has_moved) return {};
    } else if (storms(known, arrival.from, now)) {
        return {.looped = true};
    }
    const bool undecided = !known.replayed && may_be_answered(arrival.from, now);
    return {
        .suspect = true, .undecided = undecided, .ask = probed_.contains(arrival.from) ? ChannelSet{arrival.from} : ChannelSet{}};
}

// Counts a copy. True: there are too many, independent of the probes. Another sender may be faster than the first one, but not by
// `max_surplus`, and no two senders send the same frame `max_same` times in a second.
bool LoopGuard::storms(Sent& known, ChannelId from, TimePoint now) noexcept {
    if (begins_second(known.second, now)) known.originals = known.copies = 0;
    known.copied_by.insert(from);
    ++known.copies;
    const auto channels = static_cast<std::uint32_t>(known.copied_by.size()), expected = known.originals * channels;
    State& state = of(from);
    if (begins_second(state.second, now)) state.surplus = 0;
    if (known.copies > expected) ++state.surplus;
    const bool too_often = known.copies > max_same * channels;
    if (too_often && known.from != ourselves) note(known.from, known.from, known.from, true, now);
    if (!too_often && known.copies <= expected + max_surplus && state.surplus <= max_surplus) return false;
    for (const ChannelId channel : known.copied_by) note(channel, channel, channel, true, now);
    return true;
}

// Counts a command on another channel than the one that began with it. True: only a loop repeats it so often.
bool LoopGuard::is_circulating(Sent& known, ChannelId from, TimePoint now) noexcept {
    if (from == known.begun_by) return false;
    known.copied_by.insert(from);
    if (known.again < max_again) return ++known.again, false;
    for (const ChannelId channel : known.copied_by) note(channel, channel, channel, true, now);
    return true;
}

void LoopGuard::remember(const Arrival& arrival, ChannelSet channels, TimePoint now, bool replayed) noexcept {
    Sent sent;
    sent.from = sent.begun_by = arrival.from;
    sent.replayed = replayed;
    if (const Sent* known = sent_.find(arrival.key, std::min(arrival.at, now))) {
        sent = *known;
        const bool has_moved = sent.from != arrival.from && same_place(sent.from, arrival.from);    // neither is `ourselves`
        if (has_moved && !sent.channels.contains(arrival.from)) sent.from = arrival.from;
    }
    sent.channels |= channels;
    if (sent.begun_by == arrival.from)
        sent.again = static_cast<std::uint8_t>(sent.again - std::min<std::size_t>(sent.again, sent.copied_by.size()));
    if (sent.from == arrival.from) {
        sent.from_at = now;
        if (begins_second(sent.second, now)) sent.originals = sent.copies = 0;
        ++sent.originals;
    }
    const int into_loops = static_cast<int>((channels & loops_).size());
    sent.owed = static_cast<std::int8_t>(std::min(sent.owed + into_loops, max_owed));
    sent_.put(arrival.key, sent, now);
    quiet_at_ = now + window;
}

ano::FrameView LoopGuard::ask(ChannelId channel, TimePoint now) noexcept {
    State& state = of(channel);
    if (state.unanswered_since == never || now - state.asked_at >= holds) state.unanswered_since = now;
    state.asked_at = now;
    std::move_backward(state.questions.begin(), state.questions.end() - 1, state.questions.end());
    state.questions[0] = ++questions_;
    std::array<std::uint8_t, probe_data> data{};
    std::copy(probe_word.begin(), probe_word.end(), data.begin());
    for (unsigned i = 0; i < 8; ++i) data[4 + i] = static_cast<std::uint8_t>(station_ >> 8 * i);
    for (unsigned i = 0; i < 4; ++i) data[12 + i] = static_cast<std::uint8_t>(state.questions[0] >> 8 * i);
    data[16] = static_cast<std::uint8_t>(channel);
    ano::encode(probe_, ano::address::host, ano::address::broadcast, probe_id, data);
    return ano::FrameView{probe_};
}

bool LoopGuard::accept_probe(ano::FrameView probe, ChannelId from, TimePoint now) noexcept {
    const auto data = probe.data();
    std::uint64_t station = 0;
    std::uint32_t question = 0;
    for (unsigned i = 0; i < 8; ++i) station |= std::uint64_t{data[4 + i]} << 8 * i;
    for (unsigned i = 0; i < 4; ++i) question |= std::uint32_t{data[12 + i]} << 8 * i;
    if (station == station_) {
        answered(static_cast<ChannelId>(data[16] % max_channels), question, from, now);
        return false;
    }
    const std::uint64_t key = (station ^ std::uint64_t{data[16]} << 56) + std::uint64_t{question} * 0x9E3779B97F4A7C15u;
    if (others_.find(key, now)) return false;
    others_.put(key, {}, now);
    return true;
}

void LoopGuard::answered(ChannelId out, std::uint32_t question, ChannelId back, TimePoint now) noexcept {
    State& state = of(out);
    const bool is_ours = question != 0 &&
                         std::find(state.questions.begin(), state.questions.end(), question) != state.questions.end();
    if (!probed_.contains(out) || !is_ours || now - state.asked_at >= holds) return;
    state.unanswered_since = never;
    note(out, out, back, false, now);
    note(back, out, back, false, now);
}

void LoopGuard::note(ChannelId channel, ChannelId out, ChannelId back, bool by_traffic, TimePoint now) noexcept {
    State& state = of(channel);
    if (!is_loop(channel, now)) state.loop_since = now;
    state.out = out;
    state.back = back;
    state.by_traffic = by_traffic;
    state.loop_until = now + holds;
    loops_.insert(channel);
}

bool LoopGuard::is_known(const State& state, TimePoint now) const noexcept {
    if (now >= state.loop_until) return false;
    const TimePoint unanswered = of(state.out).unanswered_since;
    return state.by_traffic || unanswered == never || now - unanswered < over_after;
}

bool LoopGuard::may_be_answered(ChannelId channel, TimePoint now) const noexcept {
    const State& state = of(channel);
    const bool asked = state.unanswered_since != never && now - state.asked_at < holds;
    return probed_.contains(channel) && !(asked && now - state.unanswered_since >= slowest);
}

std::optional<LoopGuard::Loop> LoopGuard::loop(ChannelId channel, TimePoint now) const noexcept {
    const State& state = of(channel);
    if (!loops_.contains(channel) || !is_known(state, now)) return std::nullopt;
    return Loop{of(state.out).link, of(state.back).link};
}

}    // namespace anogate
