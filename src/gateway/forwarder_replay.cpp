// Processes the frames of a replayed recording.
#include <gateway/forwarder.hpp>
#include <gateway/tunnel/tunnel.hpp>

namespace anogate {

// The frame was not received on a wire, so the loop guard does not judge it, but a loop may return it. Its device may be active
// elsewhere. So no address is learned from the frame, it is not compared with live frames, and it answers no question of the
// gateway.
void Forwarder::replay(Channel& from, ano::FrameView brought) {
    const LinkEntry& link = entry(from.link);
    const ano::FrameView frame = link.aliases ? link.aliases->inbound(brought, now_) : brought;
    if (!admit(from, frame)) return;
    if (carried_.contains(from.link) && tunnel_->takes(frame)) return tunnel_->carry(from, frame);
    if (!admit_unopened(from, frame)) return;
    if (is_probe(frame)) return drop(from, frame, &ReceiveCounters::looped);    // it would be mistaken for a live probe
    entry(from.link).traffic.replayed.set(frame.source());
    Route route = router_.find(from.link, frame.destination(), now_, ano::intent_of(frame));
    route.channels.erase(from.id);
    route.guarded.erase(from.id);
    if (!route.guarded.empty()) loop_guard_.remember({frame_key(frame), from.id, arrived_at_}, route.guarded, now_, true);
    for (const ChannelId to : route.channels) offer(from.id, to, frame, policy(frame), arrived_at_);
    for (const LinkId to : route.absent) refuse(to, frame, &SendCounters::link_down);
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) drop_unrouted(from, frame);
    pass_to_own(from, frame, route.via);
}

}    // namespace anogate
