#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <gateway/forwarder.hpp>
#include <gateway/tunnel/tunnel.hpp>

#include <algorithm>

namespace anogate {
namespace {

// Whether the frame was not rewritten.
bool is_same(ano::FrameView a, ano::FrameView b) noexcept { return a.bytes().data() == b.bytes().data(); }

}    // namespace

Forwarder::Forwarder(const GatewaySettings& settings, std::uint64_t station) : router_{settings}, loop_guard_{station} {}

Forwarder::~Forwarder() = default;

void Forwarder::set_classes(const std::vector<ClassSettings>& classes) {
    policies_ = policies;
    for (const ClassSettings& of_id : classes) policies_[of_id.id] = policy_of(of_id);
}

// All frames pass these steps. As calls they would need a tenth of the time of a stream's frame, so the functions that only
// receive() uses are inline.
void Forwarder::receive(Channel& from, ano::FrameView brought, TimePoint now) {
    begin(from, brought, now);
    LinkEntry& link = entry(from.link);
    if (!link.settings.route.teaches) [[unlikely]]
        return replay(from, brought);
    const QueuePolicy policy = this->policy(brought);
    const std::uint64_t key = frame_key(brought);
    if (from.echo.is_listening(now_) && is_echo(from, brought, key)) [[unlikely]]
        return drop(from, brought, &ReceiveCounters::looped);
    ano::FrameView frame = link.aliases ? link.aliases->inbound(brought, now_) : brought;
    if (!loop_guard_.is_loop(from.id, now_) && router_.heard_again(from.id, frame.source(), now_)) note_claimants();
    LoopGuard::Arrival arrival = this->arrival(from, frame, is_same(frame, brought) ? key : frame_key(frame));
    const LoopGuard::Judgement judgement = loop_guard_.judge(arrival, now_);
    if (judgement.looped) [[unlikely]]
        return end_loop(from, frame, judgement.ask);
    if (is_duplicate(from, brought, key, policy)) return;
    if (!judgement.undecided) compare(from, frame, arrival.key);
    if (AttitudeWatch::concerns(frame.id())) [[unlikely]]
        link.traffic.attitudes.receive(frame, now_);
    if (link.present_as && !router_.claims(frame.source(), from.id)) {    // neither a copy nor a forged answer ends a question
        const ano::FrameView before = frame;
        frame = link.present_as->inbound(frame, now_);
        if (!is_same(frame, before)) arrival.key = frame_key(frame);
    }
    if (!admit(from, frame)) return;
    if (carried_.contains(from.link) && tunnel_->takes(frame)) return tunnel_->carry(from, frame);
    if (!admit_unopened(from, frame)) return;
    if (is_probe(frame)) return receive_probe(from, frame);
    pass_on(from, frame, policy, arrival, judgement);
}

[[gnu::always_inline]] inline void Forwarder::begin(Channel& from, ano::FrameView frame, TimePoint now) {
    now_ = now;
    ++frame_number_;
    note_arrival(from);
    if (!arrival_observers_.empty()) [[unlikely]]
        for (Observer* observer : arrival_observers_) observer->received(from, frame, arrived_at_);
    if (from.questions && from.questions->receive(frame, now_)) to_flush_.insert(from.id);
}

// A frame whose source is its destination is not an echo: a host and a device may have one address, and the device returns the
// value that the host wrote.
bool Forwarder::is_echo(Channel& from, ano::FrameView brought, std::uint64_t key) const {
    if (brought.source() == brought.destination() || ano::intent_of(brought) == ano::Intent::informs) return false;
    return from.echo.is_echo(key, router_.heard_at(brought.source(), from.id).has_value(), now_);
}

LoopGuard::Arrival Forwarder::arrival(const Channel& from, ano::FrameView frame, std::uint64_t key) const {
    const bool at_home = !ano::address::is_host(frame.source()) && router_.holds(frame.source(), from.id);
    const bool acts = ano::intent_of(frame) == ano::Intent::acts && policy(frame).replaces == ano::Replaces::nothing;
    return {key, from.id, arrived_at_, at_home, acts};
}

// Drops a copy that returned through a known loop. No address is learned from it.
void Forwarder::end_loop(Channel& from, ano::FrameView frame, ChannelSet ask) {
    drop(from, frame, &ReceiveCounters::looped);
    send_probes(from.id, ask);
}

// Whether the frame was already received on another link of the group. Compared as received, before any rewriting.
[[gnu::always_inline]] inline bool Forwarder::is_duplicate(Channel& from, ano::FrameView brought, std::uint64_t key,
                                                           QueuePolicy policy) {
    const std::uint8_t group = router_.group_of(from.id);
    if (group == 0) return false;
    const bool is_answer = ano::conversation::of_id[brought.id()].answers && ano::address::is_host(brought.destination());
    const auto kind = policy.replaces != Replaces::nothing ? DuplicateGuard::Kind::state
                      : is_answer                          ? DuplicateGuard::Kind::answer
                                                           : DuplicateGuard::Kind::other;
    if (!duplicates_.duplicate(key, group, from.link, kind, now_, arrived_at_)) return false;
    drop(from, brought, &ReceiveCounters::duplicate);
    return true;
}

// Equal frames of a source on two links are a conflict. A frame whose source is its destination is excluded: it may be from a
// host and a device with one address.
void Forwarder::compare(const Channel& from, ano::FrameView frame, std::uint64_t key) {
    const std::uint8_t source = frame.source();
    if (ano::address::is_host(source) || ano::address::is_nobody(source) || source == frame.destination()) return;
    const auto other = same_device_.heard(source, from.link, key, now_);
    if (!other) return;
    const std::uint8_t group = entry(from.link).settings.route.group;
    if (group != 0 && group == entry(*other).settings.route.group) return;
    const auto claimant = router_.claims(source, from.id) ? std::optional{from.id} : std::nullopt;
    router_.note_conflict(source, LinkSet{from.link} | *other, claimant, now_);
    note_claimants();
}

bool Forwarder::admit(Channel& from, ano::FrameView frame) {
    LinkEntry& link = entry(from.link);
    if (link.hello && frame.id() == firmware_id) link.hello->saw_firmware(now_);
    if (link.rules && !link.rules->takes(frame)) return drop(from, frame, &ReceiveCounters::denied_in), false;
    if (inhibit_.links().contains(from.link) && ano::is_control(frame))
        return drop(from, frame, &ReceiveCounters::inhibited), false;
    return true;
}

// Checks the content of a tunnel frame that is forwarded unopened; no other step checks it.
bool Forwarder::admit_unopened(Channel& from, ano::FrameView frame) {
    if (!inhibit_.links().contains(from.link) || !may_contain(frame, ano::is_control)) return true;
    drop(from, frame, &ReceiveCounters::inhibited);
    return false;
}

[[gnu::always_inline]] inline void Forwarder::pass_on(Channel& from, ano::FrameView frame, QueuePolicy policy,
                                                      const LoopGuard::Arrival& arrival, const LoopGuard::Judgement& judgement) {
    bool is_ours = false;
    if (!fate_observers_.empty()) [[unlikely]]
        for (Observer* observer : fate_observers_) is_ours = observer->passes(from, frame) || is_ours;
    const ano::Intent intent = ano::intent_of(frame);
    if (intent == ano::Intent::asks && ano::is_of_a_host(frame)) router_.note_host(from.id);
    const bool teaches = !judgement.undecided || ano::address::is_host(frame.source());
    Route route = teaches ? router_.route(from.id, frame.source(), frame.destination(), now_, intent)
                          : router_.spread(from.id, frame.source(), frame.destination(), now_, intent);
    if (from.answers.is_for_another(frame, now_)) [[unlikely]]
        note_device(from, frame);
    if (ano::address::is_nobody(frame.source())) [[unlikely]]
        entry(from.link).traffic.nobody = {frame.source(), now_};
    if (tunnel_ && from.link == tunnel_link_ && is_tunnel_frame(frame)) keep_from_tunnel(route);
    if (!route.guarded.empty()) loop_guard_.remember(arrival, route.guarded, now_);
    if (judgement.suspect) [[unlikely]]
        send_probes(from.id, judgement.ask | route.channels);
    to_one_place_ = route.guarded.empty();
    for (const ChannelId to : route.channels) offer(from.id, to, frame, policy, arrived_at_);
    to_one_place_ = false;
    for (const LinkId to : route.absent) refuse(to, frame, &SendCounters::link_down);
    note_receiver(from, frame, route, is_ours);
    pass_to_own(from, frame, route.via);
    if (route.new_conflict) note_claimants();
    if (router_.has_question(now_)) ask_holders();
}

// Keeps a tunnel frame that was inside another one out of the tunnel. Otherwise the next gateway would open it, and the one after
// that its content.
void Forwarder::keep_from_tunnel(Route& route) {
    const ChannelSet kept = route.channels & entry(tunnel_link_).traffic.channels;
    if (kept.empty()) return;
    route.channels -= kept;
    route.guarded -= kept;
    tunnel_->refuse_nested();
}

[[gnu::always_inline]] inline void Forwarder::note_receiver(Channel& from, ano::FrameView frame, const Route& route,
                                                            bool is_ours) {
    const bool to_host = ano::address::is_host(frame.destination());
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) {
        if (is_ours) return;
        drop_unrouted(from, frame);
        if (to_host) entry(from.link).traffic.undelivered.note(now_);
    } else if (to_host && !route.channels.empty()) {
        Undelivered& undelivered = entry(from.link).traffic.undelivered;
        if (route.host_is_down && router_.are_all_down(route.channels)) undelivered.note(now_);
        else undelivered.delivered();
    }
}

void Forwarder::drop_unrouted(Channel& from, ano::FrameView frame) {
    drop(from, frame, &ReceiveCounters::no_route);
    if (ano::intent_of(frame) == ano::Intent::acts && frame.destination() != ano::address::unassigned)
        entry(from.link).traffic.not_sent = {frame.destination(), now_};
}

// The source of the frame answers for another address. If there are several devices on the link, another gateway may have
// forwarded it.
void Forwarder::note_device(const Channel& from, ano::FrameView frame) {
    LinkEntry& link = entry(from.link);
    if (link.settings.route.acts_for_others || !router_.is_alone(frame.source(), from.id)) return;
    link.traffic.answers_for_others = {frame.source(), now_};
    router_.note_acts_for_others(from.link);
}

void Forwarder::offer(ChannelId from, ChannelId to, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at) {
    Channel& channel = *channels_[index(to)];
    const ano::FrameView before = frame;
    SendCause cause = nullptr;
    bool is_limited = false;
    if (arrived_at < now_ && channel.outbox.is_open() && channel.outbox.is_stale(policy, now_ - arrived_at)) {
        ++entry(channel.link).traffic.came_stale;
        cause = &SendCounters::stale;    // does not count for limits, and no answer is awaited
    } else {
        channel.had_host_frames = channel.had_host_frames || ano::address::is_host(frame.source());
        if (ruled_.contains(channel.link)) {
            cause = rewrite(entry(channel.link), frame);
            is_limited = channel.questions != nullptr;
        }
    }
    if (cause) {
        channel.outbox.refuse(cause);
    } else if (is_limited) {
        cause = ask(from, channel, frame, policy, arrived_at);
    } else {
        cause = channel.outbox.push(frame, policy, arrived_at, from);
        to_flush_.insert(to);
    }
    if (!cause) {
        channel.answers.sent(before, now_);
        const std::uint8_t group = router_.group_of(to);
        if ((to_one_place_ || group != 0) && ano::intent_of(frame) != ano::Intent::informs) {
            if (to_one_place_) channel.echo.sent(frame_key(frame), now_);
            duplicates_.asked(group, now_);
            if (ano::intent_of(frame) == ano::Intent::acts && policy.replaces == Replaces::nothing)
                router_.note_command(to, now_);
        }
    }
    if (!fate_observers_.empty()) [[unlikely]]
        for (Observer* observer : fate_observers_) {
            if (cause) observer->refused(channel.link, frame, cause);
            else observer->offered(channel, frame, from);
        }
}

// Rewrites the frame for the devices of the link; if it is refused, returns the cause.
SendCause Forwarder::rewrite(LinkEntry& link, ano::FrameView& frame) {
    if (link.exclusive) return &SendCounters::denied_out;
    if (const SendCause cause = link.rules ? link.rules->refusal(frame, frame_number_, now_) : nullptr) return cause;
    if (!is_probe(frame)) {    // a rewritten probe would not be recognised
        if (link.present_as) frame = link.present_as->outbound(frame, frame_number_, now_);
        const auto seen = link.aliases ? link.aliases->outbound(frame, now_) : std::optional{frame};
        if (!seen) return &SendCounters::denied_out;
        frame = *seen;
    }
    if (link.hello && frame.id() == firmware_id) link.hello->saw_firmware(now_);
    return nullptr;
}

void Forwarder::drop(Channel& from, ano::FrameView frame, ReceiveCause cause) {
    ++(from.routed.*cause);
    if (!fate_observers_.empty()) [[unlikely]]
        for (Observer* observer : fate_observers_) observer->dropped(from, frame, cause);
}

// Counts a frame for the link that was sent on none of its channels.
void Forwarder::refuse(LinkId to, ano::FrameView frame, SendCause cause) {
    SendCounters& gone = entry(to).traffic.gone_sent;
    ++gone.offered;
    ++(gone.*cause);
    if (!fate_observers_.empty()) [[unlikely]]
        for (Observer* observer : fate_observers_) observer->refused(to, frame, cause);
}

}    // namespace anogate
