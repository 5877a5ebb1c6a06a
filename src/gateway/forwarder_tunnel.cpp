// The steps for frames that are received or sent inside a tunnel frame.
#include <gateway/forwarder.hpp>

#include <algorithm>

namespace anogate {

bool Forwarder::admit(Channel& from, ano::FrameView frame, TimePoint now) {
    now_ = now;
    note_arrival(from);
    if (!arrival_observers_.empty()) [[unlikely]]
        for (Observer* observer : arrival_observers_) observer->received(from, frame, arrived_at_);
    return admit(from, frame);
}

// An inhibit switch also blocks control frames inside a tunnel frame.
bool Forwarder::passes_into_tunnel(Channel& from, ano::FrameView inner, TimePoint now) {
    now_ = now;
    note_arrival(from);
    if (!admit(from, inner) || !admit_unopened(from, inner) || !passes_loop_guard(from, inner, tunnel_link_)) return false;
    learn(from, inner);
    return may_leave(tunnel_link_, inner);
}

bool Forwarder::passes_to_wrap(Channel& from, ano::FrameView frame, LinkId to, TimePoint now) {
    return admit(from, frame, now) && admit_unopened(from, frame) && passes_loop_guard(from, frame, to) && may_leave(to, frame);
}

// The loop guard for frames that are sent without Router::route().
bool Forwarder::passes_loop_guard(Channel& from, ano::FrameView frame, LinkId to) {
    const LoopGuard::Arrival arrival = this->arrival(from, frame, frame_key(frame));
    const LoopGuard::Judgement judgement = loop_guard_.judge(arrival, now_);
    if (judgement.looped) return end_loop(from, frame, judgement.ask), false;
    const ChannelSet channels = entry(to).traffic.channels;
    if (judgement.suspect) send_probes(from.id, judgement.ask | channels);
    loop_guard_.remember(arrival, channels, now_);
    return true;
}

// The send filter and limits of `to`.
bool Forwarder::may_leave(LinkId to, ano::FrameView frame) {
    LinkEntry& link = entry(to);
    const bool is_stale = now_ - arrived_at_ >= limit(link.settings.outbox.age, policy(frame));
    if (is_stale) return refuse(to, frame, &SendCounters::stale), false;
    const SendCause cause = link.rules ? link.rules->refusal(frame, ++frame_number_, now_) : nullptr;
    if (cause) return refuse(to, frame, cause), false;
    if (link.hello && frame.id() == firmware_id) link.hello->saw_firmware(now_);
    return true;
}

void Forwarder::learn(Channel& from, ano::FrameView frame, TimePoint now) {
    now_ = now;
    learn(from, frame);
}

void Forwarder::learn(Channel& from, ano::FrameView frame) {
    router_.learn(from.id, frame.source(), now_);
    note_claimants();
    if (router_.has_question(now_)) ask_holders();
}

void Forwarder::send(LinkId to, ano::FrameView frame, TimePoint now) {
    now_ = now;
    ++frame_number_;
    const ChannelSet channels = entry(to).traffic.channels;
    if (channels.empty()) refuse(to, frame, &SendCounters::link_down);
    for (const ChannelId channel : channels) offer(ourselves, channel, frame, policy(frame), arrived_at_);
}

}    // namespace anogate
