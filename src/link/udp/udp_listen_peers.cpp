// UdpListenLink: accepting and removing peers.
#include <link/feed.hpp>
#include <link/udp/udp_listen_link.hpp>
#include <link/udp/udp_listen_peer.hpp>

#include <algorithm>
#include <new>

namespace anogate {
namespace {

constexpr Duration read_first = std::chrono::seconds{1};
constexpr std::size_t max_at_eviction = 1024;    // bytes, about as many as the first datagram of the new peer may have

}    // namespace

std::vector<StoredPeer> UdpListenLink::peers() const {
    std::vector<StoredPeer> peers;
    for (const auto& peer : peers_)
        if (!peer->is_gateway) peers.push_back({peer->endpoint, book_.memory(peer->channel.id), !peer->far});
    return peers;
}

// Restores stored peers, because peers that only receive would not register again. The current settings decide whether they are
// admitted.
void UdpListenLink::restore_peers(std::vector<StoredPeer> peers, TimePoint now) try {
    std::sort(peers.begin(), peers.end(),
              [](const StoredPeer& a, const StoredPeer& b) { return a.memory.heard_at > b.memory.heard_at; });
    for (const StoredPeer& stored : peers) {
        if (find(stored.endpoint) || !allowed(stored.endpoint, now) || !can_be_peer(stored.endpoint, now)) continue;
        const PeerBook::Rank rank = rank_of(stored.endpoint, stored.memory.commands);
        const PeerBook::Place place = book_.place_for(stored.endpoint, now, rank, stored.memory.commands);
        if (!place.free || place.evicted) continue;
        Peer* const peer = make_peer(stored.endpoint, now, rank);
        if (!peer) return;
        peer->came = true;
        if (stored.is_proven) peer->far.reset();
        peer->channel.heard_at = stored.memory.heard_at;
        book_.remember(peer->channel.id, stored.memory);
    }
    if (!peers_.empty()) look_.set(book_.next_look(now));
} catch (const std::bad_alloc&) {
    return;    // they are registered again when they send
}

UdpListenLink::Peer* UdpListenLink::find(const Endpoint& endpoint) noexcept {
    if (latest_ && latest_->endpoint == endpoint) return latest_;
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->endpoint == endpoint; });
    return found == peers_.end() ? nullptr : found->get();
}

// An unknown sender must be allowed and must send a V8 frame; it may replace another peer.
UdpListenLink::Peer* UdpListenLink::admit(const Endpoint& endpoint, std::span<const std::uint8_t> datagram, TimePoint now) try {
    if (!allowed(endpoint, now)) {
        ++outsiders_;
        return refuse(datagram), nullptr;
    }
    if (!can_be_peer(endpoint, now)) return refuse(datagram), nullptr;
    bool commands = false;
    if (!is_admitted(endpoint, datagram, now, commands)) return nullptr;
    if (check_.is_refused(endpoint)) {    // a gateway that was not yet notified of the refusal
        send_notice(endpoint, check_.question_back(endpoint, now));
        return refuse(datagram), nullptr;
    }
    if (check_.is_suspended(endpoint, now)) {
        ++unassigned_.suspended;
        unassigned_.bytes_in += datagram.size();
        return nullptr;
    }
    const PeerBook::Rank rank = rank_of(endpoint, commands);
    const PeerBook::Place place = book_.place_for(endpoint, now, rank, commands);
    if (!place.free) {
        ++no_place_;
        return refuse(datagram), nullptr;
    }
    if (place.evicted) evict(*place.evicted, now);
    Peer* peer = make_peer(endpoint, now, rank);
    if (!peer) refuse(datagram);
    return peer;
} catch (const std::bad_alloc&) {
    ++no_memory_;
    return refuse(datagram), nullptr;    // no exception: it would end the program
}

void UdpListenLink::refuse(std::span<const std::uint8_t> datagram) {
    ++unassigned_.denied_in;
    unassigned_.bytes_in += datagram.size();
}

// A peer needs about 100 KB, so the allocation may fail.
UdpListenLink::Peer* UdpListenLink::make_peer(const Endpoint& endpoint, TimePoint now, PeerBook::Rank rank) {
    const bool near = networks_.contain(endpoint.address, now), far = is_far(endpoint.address, now);
    context_.host.make_channel_free(rank);
    Channel* channel = context_.host.open_channel(*this, endpoint.text());
    if (!channel) return no_channel_.add(now), nullptr;
    try {
        auto peer = std::make_unique<Peer>(*this, endpoint, *channel);
        if (far) peer->far = std::make_unique<FarPeer>(now);
        peers_.push_back(std::move(peer));
    } catch (const std::bad_alloc&) {
        context_.host.close_channel(*channel, {});
        throw;
    }
    if (!settings().group.empty() && !is_trusted(endpoint.address)) context_.host.leave_group(*channel);
    channel->heard_at = now;         // its first frame may still be waiting behind a false header
    context_.host.link_up(*this);    // for the new channel
    book_.add(channel->id, endpoint, near, now, rank);
    look_.set_no_later(book_.next_look(now));
    return peers_.back().get();
}

// Refuses our own socket and the sockets of our other links.
bool UdpListenLink::can_be_peer(const Endpoint& sender, TimePoint now) {
    const bool near = networks_.contain(sender.address, now);
    if (!anogate::can_be_peer(sender, networks_.all())) return false;
    if (!near || !context_.host.is_own_port(sender.port)) return true;
    return !sender.address.is_loopback() && !networks_.have(sender.address, now);
}

bool UdpListenLink::is_trusted(const IpAddress& address) const {
    const UdpListenSettings& udp = settings().as<UdpListenSettings>();
    return udp.trusted_any || contains(udp.trusted, address);
}

PeerBook::Rank UdpListenLink::rank_of(const Endpoint& endpoint, bool commands) const {
    if (contains(settings().as<UdpListenSettings>().trusted, endpoint.address)) return PeerBook::Rank::trusted;
    return commands ? PeerBook::Rank::commands : PeerBook::Rank::ordinary;
}

bool UdpListenLink::is_far(const IpAddress& address, TimePoint now) {
    return !joins_gateways() && !is_trusted(address) && !networks_.contain(address, now);
}

bool UdpListenLink::allowed(const Endpoint& sender, TimePoint now) {
    const UdpListenSettings& udp = settings().as<UdpListenSettings>();
    if (udp.allow_any || contains(udp.allow, sender.address)) return true;
    return udp.allow.empty() && networks_.contain(sender.address, now);
}

// Sets `commands` if the datagram contains a command of a host.
bool UdpListenLink::is_admitted(const Endpoint& sender, std::span<const std::uint8_t> datagram, TimePoint now, bool& commands) {
    if (v7_probe_) return has_v7_frame(datagram, commands);
    const ano::ParserCounters before = probe_.counters();
    bool found = false;
    std::uint64_t unwelcome = 0;
    bool is_notice = false;
    const auto look = [&](ano::FrameView frame) {
        if (const auto notice = listening_notice(frame)) {
            is_notice = true;
            if (!joins_gateways()) heard_notice(sender, *notice, now);
        } else if (found || welcomes(sender, frame)) {
            found = true;
            commands = commands || is_command_of_host(frame);
        } else ++unwelcome;
    };
    feed_datagram(probe_, datagram, now, look);
    probe_.finish();
    while (const auto frame = probe_.next()) look(*frame);
    if (found && !is_notice) return true;
    unassigned_.denied_in += unwelcome;
    const ano::ParserCounters& after = probe_.counters();
    unassigned_.bytes_in += datagram.size();
    unassigned_.skipped_bytes += after.skipped_bytes - before.skipped_bytes;
    unassigned_.bad_check += after.bad_check - before.bad_check;
    unassigned_.bad_length += after.bad_length - before.bad_length;
    unassigned_.expired += after.expired - before.expired;
    return false;
}

bool UdpListenLink::has_v7_frame(std::span<const std::uint8_t> datagram, bool& commands) {
    const ano::v7::ParserCounters before = v7_probe_->counters();
    bool found = false;
    for (auto rest = datagram; !rest.empty();) {
        const auto room = v7_probe_->prepare();
        const std::size_t n = std::min(room.size(), rest.size());
        std::copy_n(rest.begin(), n, room.begin());
        v7_probe_->commit(n, {});
        rest = rest.subspan(n);
        if (rest.empty()) v7_probe_->finish();
        while (const auto frame = v7_probe_->next()) {
            found = true;
            commands = commands || is_v7_command_of_host(settings().as<UdpListenSettings>().v7, frame->id());
        }
    }
    if (found) return true;
    const ano::v7::ParserCounters& after = v7_probe_->counters();
    unassigned_.bytes_in += datagram.size();
    unassigned_.skipped_bytes += after.skipped_bytes - before.skipped_bytes;
    unassigned_.bad_check += after.bad_check - before.bad_check;
    unassigned_.bad_length += after.bad_length - before.bad_length;
    unassigned_.expired += after.expired - before.expired;
    return false;
}

void UdpListenLink::forget(Peer& peer) {
    if (latest_ == &peer) latest_ = nullptr;
    Channel& channel = peer.channel;
    if (peer.waiting) channel.routed.over_share += peer.waiting->count();
    waiting_.erase(channel.id);
    book_.remove(channel.id);
    check_.forget(peer.endpoint);
    if (peer.v7) add(v7_of_gone_, peer.v7->counters());
    std::erase_if(peers_, [&](const auto& p) { return p.get() == &peer; });
    context_.host.close_channel(channel, {});
}

// Its waiting datagrams were received while it was a peer, and one of them may be a command.
void UdpListenLink::evict(ChannelId channel, TimePoint now) {
    for (std::size_t bytes = 0; waiting_.contains(channel) && bytes < max_at_eviction;)
        bytes += process_next(peer_of(channel), now);
    forget_peer(channel);
}

void UdpListenLink::forget_peer(ChannelId channel) {
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->channel.id == channel; });
    if (found != peers_.end()) forget(**found);
}

void UdpListenLink::forget_overdue_peers() {
    const StallDetector& loop = context_.host.turn();
    const TimePoint now = loop.now();
    if (now < loop.last_standstill() + read_first)
        return look_.set(now + read_first);    // frames that arrived during a standstill may not be read yet
    const ChannelSet overdue = book_.overdue(now);
    for (std::size_t i = peers_.size(); i-- > 0;)
        if (overdue.contains(peers_[i]->channel.id) || peers_[i]->is_gateway) forget(*peers_[i]);
    if (!peers_.empty()) look_.set(book_.next_look(now));
}

}    // namespace anogate
