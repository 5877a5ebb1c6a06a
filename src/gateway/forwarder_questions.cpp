// The frames that the gateway sends without a request: probes, hellos, questions to holders of claimed addresses; and their
// times.
#include <gateway/forwarder.hpp>

#include <algorithm>

namespace anogate {
namespace {

constexpr QueuePolicy probe_policy{TrafficClass::urgent, Replaces::nothing, AgeKind::rest};

}    // namespace

Channel* Forwarder::next_to_flush() noexcept {
    while (!to_flush_.empty()) {
        const ChannelId id = *to_flush_.begin();
        to_flush_.erase(id);
        if (!channels_[index(id)]->outbox.empty()) return channels_[index(id)].get();
    }
    return nullptr;
}

std::optional<TimePoint> Forwarder::due() const noexcept {
    TimePoint first = questions_due_;
    if (const auto question = router_.next_question(); question && asks_) first = std::min(first, *question);
    return first == TimePoint::max() ? std::nullopt : std::optional{first};
}

void Forwarder::tick(TimePoint now) {
    now_ = now;
    if (now_ >= questions_due_) release_questions();
    if (asks_ && router_.has_question(now_)) ask_holders();
}

void Forwarder::send_own(ChannelId to, ano::FrameView frame, TimePoint now) {
    now_ = now;
    send_own(to, frame);
}

void Forwarder::send_own(ChannelId to, ano::FrameView frame) {
    ++frame_number_;
    offer(ourselves, to, frame, policy(frame), now_);
}

ano::Flush Forwarder::flush_parsers(LinkId from, ano::FrameView frame, TimePoint now) {
    now_ = now;
    ano::Flush all;
    for (const ChannelId to : router_.find(from, frame.destination(), now_, ano::intent_of(frame)).channels) {
        const auto& rules = entry(channels_[index(to)]->link).rules;
        if (!rules || rules->sends(frame)) all = all | flush_parser(to);
    }
    return all;
}

ano::Flush Forwarder::flush_parser(ChannelId to) {
    Channel& channel = *channels_[index(to)];
    if (entry(channel.link).exclusive || channel.waiting() > 0) return {};
    if (!channel.outbox.flush_parser(now_)) return {.later = channel.outbox.until_flush(now_)};
    to_flush_.insert(to);
    const ForwarderLink& settings = entry(channel.link).settings;
    return {.sent = true, .busy = time_of_flush(channel.outbox.zeros(), settings.parser.line_rate)};
}

// Without alias, loop guard and group, since the frame was not received on a wire.
void Forwarder::send_on(Channel& from, ano::FrameView frame, TimePoint now) {
    now_ = now;
    ++frame_number_;
    note_arrival(from);
    if (!arrival_observers_.empty()) [[unlikely]]
        for (Observer* observer : arrival_observers_) observer->received(from, frame, arrived_at_);
    if (is_probe(frame)) return drop(from, frame, &ReceiveCounters::looped);    // it would be mistaken for a probe of ours
    if (!admit(from, frame) || !admit_unopened(from, frame)) return;
    const Route route = router_.find(from.link, frame.destination(), now_, ano::intent_of(frame));
    if (!route.guarded.empty()) loop_guard_.remember({frame_key(frame), ourselves, now_}, route.guarded, now_);
    to_one_place_ = route.guarded.empty();
    for (const ChannelId to : route.channels) offer(ourselves, to, frame, policy(frame), arrived_at_);
    to_one_place_ = false;
    for (const LinkId to : route.absent) refuse(to, frame, &SendCounters::link_down);
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) drop_unrouted(from, frame);
    pass_to_own(from, frame, route.via);
}

void Forwarder::answer(ChannelId to, ano::FrameView frame, TimePoint now) {
    now_ = now;
    send_own_and_remember(to, frame);
}

void Forwarder::send_to_active_channels(ano::FrameView frame, TimePoint now) {
    now_ = now;
    ++frame_number_;
    ChannelSet heard;
    for (const ChannelId id : used_)
        if (router_.heard_at(frame.destination(), id)) heard.insert(id);
    if (!heard.empty())
        loop_guard_.remember({frame_key(frame), ourselves, now_}, heard, now_);    // it may be received again on
                                                                                   // any link
    for (const ChannelId to : heard) offer(ourselves, to, frame, policy(frame), now_);
}

// Stores the frame in the loop guard, since it may be received again on any link.
void Forwarder::send_own_and_remember(ChannelId to, ano::FrameView frame) {
    send_own(to, frame);
    loop_guard_.remember({frame_key(frame), ourselves, now_}, to, now_);
}

// Probes are sent before the frame of `from` that caused them, and wait under its sender: in a loop they return before it.
void Forwarder::send_probes(ChannelId from, ChannelSet channels) {
    for (const ChannelId channel : channels& used_) {
        if (!loop_guard_.is_due(channel, now_)) continue;
        ++frame_number_;
        offer(from, channel, loop_guard_.ask(channel, now_), probe_policy, now_);
        ++frame_number_;
    }
}

// No address is learned from a probe, since any gateway may have forwarded it.
void Forwarder::receive_probe(Channel& from, ano::FrameView probe) {
    if (!loop_guard_.accept_probe(probe, from.id, now_)) return drop(from, probe, &ReceiveCounters::looped);
    const std::uint8_t group = router_.group_of(from.id);
    for (const ChannelId to : (loop_guard_.probed() & used_) - from.id)
        if (group == 0 || router_.group_of(to) != group)
            offer(from.id, to, probe, probe_policy, now_);    // before the frame, too
}

SendCause Forwarder::ask(ChannelId from, Channel& channel, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at) {
    const SendCause cause = channel.questions->push(frame, policy, now_, from, arrived_at);
    to_flush_.insert(channel.id);
    const auto due = channel.questions->next_look(now_);
    if (due && asks_) questions_due_ = std::min(questions_due_, *due);
    return cause;
}

// Unanswered questions expire here, and waiting ones take their places.
void Forwarder::release_questions() {
    questions_due_ = TimePoint::max();
    for (const ChannelId id : used_) {
        const auto& questions = channels_[index(id)]->questions;
        if (!questions) continue;
        if (questions->release(now_)) to_flush_.insert(id);
        if (const auto due = questions->next_look(now_)) questions_due_ = std::min(questions_due_, *due);
    }
}

// Asks the holders of claimed addresses.
void Forwarder::ask_holders() {
    while (const auto question = router_.pop_question(now_)) {
        const auto bytes = device_info_question(question->address);
        for (const ChannelId to : question->channels) send_own_and_remember(to, ano::FrameView{bytes});
        ++frame_number_;
    }
}

// Sends a hello on links on which nothing is received.
void Forwarder::send_hellos(TimePoint now) {
    now_ = now;
    for (const LinkId id : added_) {
        LinkEntry& link = entry(id);
        const auto due = link.hello ? link.hello->due(heard_at(link)) : std::nullopt;
        if (!due || *due > now_) continue;
        for (const ChannelId to : link.traffic.channels) {
            if (link.hello->may_be_deaf(heard_at(link))) flush_parser(to);
            send_own_and_remember(to, ano::FrameView{hello_frame});
        }
        link.hello->sent(now_, heard_at(link));
    }
    await_hellos();
}

// Computes the earliest time at which a hello can be due. Frames that are received meanwhile can only make it later.
void Forwarder::await_hellos() {
    hello_due_.reset();
    if (!asks_) return;
    for (const LinkId id : added_) {
        const LinkEntry& link = entry(id);
        if (const auto due = link.hello ? link.hello->due(heard_at(link)) : std::nullopt)
            hello_due_ = std::min(hello_due_.value_or(TimePoint::max()), *due);
    }
}

TimePoint Forwarder::heard_at(const LinkEntry& link) const {
    TimePoint latest{};
    for (const ChannelId id : link.traffic.channels) latest = std::max(latest, channels_[index(id)]->heard_at);
    return latest;
}

// Called before the channel of the claimant can be closed.
void Forwarder::note_claimants() {
    Router::Claimant claims;
    while (router_.pop_claimant(claims)) {
        const Channel& channel = *channels_[index(claims.channel)];
        claimants_[claims.address] = {channel.link, channel.peer};
    }
}

std::optional<Conflict> Forwarder::pop_conflict() {
    Conflict conflict;
    return router_.pop_new_conflict(conflict) ? std::optional{conflict} : std::nullopt;
}

const Forwarder::Claimant* Forwarder::claimant(const Conflict& conflict) const {
    const auto found = claimants_.find(conflict.address);
    return conflict.claimed && found != claimants_.end() ? &found->second : nullptr;
}

bool Forwarder::is_elsewhere(const Channel& from, std::uint8_t source) const noexcept {
    if (from.id == ourselves) return false;
    const LinkEntry& link = entry(from.link);
    return router_.claims(link.aliases ? link.aliases->appears_as(source) : source, from.id);
}

}    // namespace anogate
