#include <ano/address.hpp>
#include <gateway/forwarder.hpp>
#include <gateway/tunnel.hpp>

#include <algorithm>

namespace anogate {
namespace {

// Whether the frame was not rewritten.
bool is_same(ano::FrameView a, ano::FrameView b) noexcept { return a.bytes().data() == b.bytes().data(); }

}    // namespace

Forwarder::Forwarder(const GatewaySettings& settings, std::uint64_t station) : router_{settings}, loop_guard_{station} {}

Forwarder::~Forwarder() = default;

// Every frame takes these steps: as calls they would take a tenth of the time of a frame of a stream, so those that only receive()
// uses are inline.
void Forwarder::receive(Channel& from, ano::FrameView brought, TimePoint now) {
    begin(from, brought, now);
    LinkEntry& link = entry(from.link);
    if (!link.settings.route.teaches) [[unlikely]]
        return replay(from, brought);
    const QueuePolicy policy = policy_of(brought.id());
    const std::uint64_t key = frame_key(brought);
    ano::FrameView frame = link.aliases ? link.aliases->inbound(brought, now_) : brought;
    if (!loop_guard_.rings().is_ring(from.id, now_) && router_.heard_again(from.id, frame.source(), now_)) note_claimants();
    Said said = said_at(from, frame, is_same(frame, brought) ? key : frame_key(frame));
    said.waited = releasing_;
    said.hurried = hurrying_;
    std::uint32_t copies = 1;
    if (goes_round(from, frame, brought, said, copies) || is_duplicate(from, brought, key, policy)) return;
    compare(from, frame, said.key);
    if (link.present_as) {    // after the guards: a copy must not end a question
        const ano::FrameView before = frame;
        frame = link.present_as->inbound(frame, now_);
        if (!is_same(frame, before)) said.key = frame_key(frame);
    }
    if (!admit(from, frame)) return;
    if (carried_.contains(from.link) && tunnel_->takes(frame)) return tunnel_->carry(from, frame);
    if (!admit_unopened(from, frame)) return;
    if (is_probe(frame)) return take_probe(from, frame);
    pass_on(from, frame, policy, said, copies);
}

[[gnu::always_inline]] inline void Forwarder::begin(Channel& from, ano::FrameView frame, TimePoint now) {
    now_ = now;
    if (!held_.empty()) make_room_for(from, frame);
    ++frame_number_;
    note_arrival(from);
    if (!hear_arrivals_.empty() && !releasing_) [[unlikely]]
        for (Observer* observer : hear_arrivals_) observer->received(from, frame, arrived_at_);
    if (from.questions && from.questions->hear(frame, now_)) to_flush_.insert(from.id);
}

Said Forwarder::said_at(const Channel& from, ano::FrameView frame, std::uint64_t key) const {
    Said said = said_by(frame, key);
    said.speaks = router_.speaks(frame.source(), from.id);
    said.arrived = arrived_at_;
    return said;
}

// True: a copy that came back by another way, or it waits until that is known. It waits as `brought`, without its alias.
// `copies`: how often it is to be sent, including the withheld ones.
[[gnu::always_inline]] inline bool Forwarder::goes_round(Channel& from, ano::FrameView frame, ano::FrameView brought,
                                                         const Said& said, std::uint32_t& copies) {
    if (!held_.empty() && !releasing_ && keeps_order(frame))    // frames of a host keep their order
        if (const auto due = held_.due(from.id); due && hold(from, brought, *due)) return true;
    from.routed.looped += loop_guard_.take_lost(from.id, now_);
    const LoopGuard::Judgement judgement = loop_guard_.judge(said, from.id, now_);
    copies = judgement.copies;
    if (judgement.probe) send_probe(from.id);
    if (judgement.fate == LoopGuard::Fate::waits && !releasing_ &&
        hold(from, brought, now_ + judgement.wait, {judgement.repeats, now_ + LoopGuard::come_together}))
        return true;
    if (judgement.fate == LoopGuard::Fate::ends) {
        if (judgement.elsewhere) compare(from, frame, said.key);
        end_loop(from, frame);
        return true;
    }
    return judgement.fate == LoopGuard::Fate::withheld;
}

// The address of a host is learned all the same, so that answers reach it here too; but not from a known ring.
void Forwarder::end_loop(Channel& from, ano::FrameView frame) {
    drop(from, frame, &ReceiveCounters::looped);
    if (ano::address::is_host(frame.source()) && !loop_guard_.rings().is_ring(from.id, now_)) learn(from, frame);
}

// Whether another link of the group brought the frame already: compared as `brought`, before any rewriting.
[[gnu::always_inline]] inline bool Forwarder::is_duplicate(Channel& from, ano::FrameView brought, std::uint64_t key,
                                                           QueuePolicy policy) {
    const std::uint8_t group = entry(from.link).settings.route.group;
    if (group == 0 || !duplicates_.duplicate(key, group, from.link, policy.replaces, now_, arrived_at_)) return false;
    drop(from, brought, &ReceiveCounters::duplicate);
    return true;
}

// A source on two links is a conflict, even when its copies are dropped.
void Forwarder::compare(const Channel& from, ano::FrameView frame, std::uint64_t key) {
    const std::uint8_t source = frame.source();
    if (ano::address::is_host(source)) return;
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
    if (inhibit_.links().contains(from.link) && is_control(frame)) return drop(from, frame, &ReceiveCounters::inhibited), false;
    return true;
}

// The content of a tunnel frame that is forwarded unopened is checked nowhere else.
bool Forwarder::admit_unopened(Channel& from, ano::FrameView frame) {
    if (!inhibit_.links().contains(from.link) || !may_bring_control(frame)) return true;
    drop(from, frame, &ReceiveCounters::inhibited);
    return false;
}

[[gnu::always_inline]] inline void Forwarder::pass_on(Channel& from, ano::FrameView frame, QueuePolicy policy, const Said& said,
                                                      std::uint32_t copies) {
    bool is_ours = false;
    if (!hear_fates_.empty()) [[unlikely]]
        for (Observer* observer : hear_fates_) is_ours = observer->passes(from, frame) || is_ours;
    Route route = router_.route(from.id, frame.source(), frame.destination(), now_);
    if (tunnel_ && from.link == tunnel_link_ && is_tunnel_frame(frame)) keep_from_tunnel(route);
    if (!route.guarded.empty()) loop_guard_.remember(said, from.id, route.guarded, now_);
    for (; copies > 0; --copies)
        for (const ChannelId to : route.channels) offer(from.id, to, frame, policy, arrived_at_);
    for (const LinkId to : route.absent) refuse(to, frame, &SendCounters::link_down);
    note_taker(from, frame, route, is_ours);
    tell_own(from, frame, route.via);
    if (route.new_conflict) note_claimants();
    if (router_.has_question(now_)) ask_holders();
}

// Keeps a tunnel frame that came inside another one from the tunnel: the next gateway would open it, and the one after that its
// content.
void Forwarder::keep_from_tunnel(Route& route) {
    const ChannelSet kept = route.channels & entry(tunnel_link_).traffic.channels;
    if (kept.empty()) return;
    route.channels -= kept;
    route.guarded -= kept;
    tunnel_->refuse_nested();
}

[[gnu::always_inline]] inline void Forwarder::note_taker(Channel& from, ano::FrameView frame, const Route& route, bool is_ours) {
    const bool to_host = ano::address::is_host(frame.destination());
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) {
        if (is_ours) return;
        drop(from, frame, &ReceiveCounters::no_route);
        if (to_host) entry(from.link).traffic.untaken.note(now_);
    } else if (to_host && !route.channels.empty()) {
        Untaken& untaken = entry(from.link).traffic.untaken;
        if (route.host_is_down && router_.are_all_down(route.channels)) untaken.note(now_);
        else untaken.taken();
    }
}

void Forwarder::offer(ChannelId from, ChannelId to, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at) {
    Channel& channel = *channels_[index(to)];
    SendCause cause = nullptr;
    bool takes_few = false;
    if (arrived_at < now_ && channel.outbox.is_open() && channel.outbox.is_stale(policy, now_ - arrived_at)) {
        ++entry(channel.link).traffic.came_stale;
        cause = &SendCounters::stale;    // it does not count for limits, and no answer is awaited
    } else {
        channel.hosts_spoke = channel.hosts_spoke || ano::address::is_host(frame.source());
        if (ruled_.contains(channel.link)) {
            cause = rewrite(entry(channel.link), frame);
            takes_few = channel.questions != nullptr;
        }
    }
    if (cause) {
        channel.outbox.refuse(cause);
    } else if (takes_few) {
        cause = ask(from, channel, frame, policy, arrived_at);
    } else {
        cause = channel.outbox.push(frame, policy, arrived_at, from);
        to_flush_.insert(to);
    }
    if (!hear_fates_.empty()) [[unlikely]]
        for (Observer* observer : hear_fates_) {
            if (cause) observer->refused(channel.link, frame, cause);
            else observer->offered(channel, frame, from);
        }
}

// Rewrites the frame as the link's devices are to see it; otherwise returns the cause of the refusal.
SendCause Forwarder::rewrite(LinkEntry& link, ano::FrameView& frame) {
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
    if (!hear_fates_.empty()) [[unlikely]]
        for (Observer* observer : hear_fates_) observer->dropped(from, frame, cause);
}

// Counts a frame that was for the link but for none of its channels.
void Forwarder::refuse(LinkId to, ano::FrameView frame, SendCause cause) {
    SendCounters& gone = entry(to).traffic.gone_sent;
    ++gone.offered;
    ++(gone.*cause);
    if (!hear_fates_.empty()) [[unlikely]]
        for (Observer* observer : hear_fates_) observer->refused(to, frame, cause);
}

}    // namespace anogate
