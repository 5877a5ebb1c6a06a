// UdpListenLink: datagrams that are read while those of other peers are processed wait, and each peer gets the same share of the
// time.
#include <link/udp/udp_listen_link.hpp>
#include <link/udp/udp_listen_peer.hpp>

#include <algorithm>
#include <new>

namespace anogate {

// The datagrams of a single peer never wait, because they delay no others.
bool UdpListenLink::is_crowded() const { return !waiting_.empty() || (peers_.size() > 1 && ano::Clock::now() >= turn_ends_); }

void UdpListenLink::store(Peer& peer, std::span<const std::uint8_t> datagram, TimePoint arrived_at) try {
    if (!peer.waiting) peer.waiting = std::make_unique<DatagramQueue>();
    if (!waiting_.contains(peer.channel.id)) shares_.begins(peer.channel.id);
    peer.channel.routed.over_share += peer.waiting->push(datagram, arrived_at);
    waiting_.insert(peer.channel.id);
} catch (const std::bad_alloc&) {
    ++peer.channel.routed.over_share;
}

// At least one datagram, and more until `time` is over.
void UdpListenLink::process_waiting(Duration time) {
    if (waiting_.empty()) return;
    const TimePoint now = context_.host.now();
    const TimePoint ends = now + time;
    for (TimePoint before = now; !waiting_.empty() && (before == now || before < ends);) {
        const ChannelId id = shares_.next(waiting_);
        process_next(peer_of(id), now);
        const TimePoint after = ano::Clock::now();
        shares_.charge(id, after - before);
        before = after;
    }
    if (!waiting_.empty()) return next_turn_.set(now);
    for (const auto& peer : peers_) peer->waiting.reset();
}

// Returns the size of the datagram. May remove the peer.
std::size_t UdpListenLink::process_next(Peer& peer, TimePoint now) {
    const DatagramQueue::Datagram next = peer.waiting->pop();
    if (peer.waiting->empty()) waiting_.erase(peer.channel.id);
    receive(peer, next.bytes, next.arrived_at, now);
    return next.bytes.size();
}

UdpListenLink::Peer& UdpListenLink::peer_of(ChannelId channel) noexcept {
    return **std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->channel.id == channel; });
}

}    // namespace anogate
