// What was said once and is said again: nobody's word of now.
#include <gateway/forwarder.hpp>
#include <gateway/tunnel.hpp>

namespace anogate {

// It comes from no wire, so no guard judges it, but it may come back by one. It teaches no
// address, is compared with nothing that is said now and answers no question of the gateway: whoever it is of may be alive
// elsewhere.
void Forwarder::replay(Channel& from, ano::FrameView brought) {
    const LinkEntry& link = entry(from.link);
    const ano::FrameView frame = link.aliases ? link.aliases->inbound(brought, now_) : brought;
    if (!admit(from, frame)) return;
    if (carried_.contains(from.link) && tunnel_->takes(frame)) return tunnel_->carry(from, frame);
    if (!admit_unopened(from, frame)) return;
    if (is_probe(frame)) return drop(from, frame, &ReceiveCounters::looped);    // it would be taken for a question of now
    entry(from.link).traffic.replayed.set(frame.source());
    Route route = router_.find(from.link, frame.destination(), now_);
    route.channels.erase(from.id);
    route.guarded.erase(from.id);
    Said said = said_by(frame);
    said.replayed = true;
    if (!route.guarded.empty()) loop_guard_.remember(said, from.id, route.guarded, now_);
    for (const ChannelId to : route.channels) offer(from.id, to, frame, policy_of(frame.id()), arrived_at_);
    for (const LinkId to : route.absent) refuse(to, frame, &SendCounters::link_down);
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) drop(from, frame, &ReceiveCounters::no_route);
    tell_own(from, frame, route.via);
}

}    // namespace anogate
