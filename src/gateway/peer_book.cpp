#include <ano/address.hpp>
#include <gateway/peer_book.hpp>

#include <algorithm>

namespace anogate {

void PeerBook::add(ChannelId id, const Endpoint& endpoint, bool near, TimePoint now) {
    used_.insert(id);
    peer(id) = {};
    peer(id).endpoint = endpoint;
    peer(id).near = near;
    peer(id).heard_at = now;
}

void PeerBook::heard(ChannelId id, std::uint8_t source, TimePoint now) noexcept {
    Peer& p = peer(id);
    p.heard_at = now;
    p.is_host = p.is_host || ano::address::is_host(source);
    p.refusals = 0;
    p.is_gone = false;
}

bool PeerBook::refused(ChannelId id, TimePoint now) noexcept {
    Peer& p = peer(id);
    if (p.refusals == 0) p.first_refused_at = now;
    ++p.refusals;
    p.is_gone = p.is_gone || (p.refusals >= enough_refusals && now - p.first_refused_at >= refused_for);
    return p.is_gone;
}

ChannelSet PeerBook::overdue(TimePoint now) const noexcept {
    ChannelSet result;
    for (const ChannelId id : used_)
        if (is_overdue(id, now)) result.insert(id);
    return result;
}

bool PeerBook::is_overdue(ChannelId id, TimePoint now) const noexcept {
    const Peer& p = peer(id);
    if (p.is_gone) return true;
    if (!is_silent(p, now)) return false;
    if (!may_listen(p) || now >= longest_stay(p)) return true;
    std::size_t later = 0;    // silent ones of its address, heard after it
    for (const ChannelId other : used_) {
        const Peer& o = peer(other);
        if (o.endpoint.address != p.endpoint.address || o.is_gone || !may_listen(o) || !is_silent(o, now)) continue;
        if (o.heard_at > p.heard_at || (o.heard_at == p.heard_at && index(other) > index(id))) ++later;
    }
    return later >= most_silent_of_address;
}

TimePoint PeerBook::longest_stay(const Peer& p) const noexcept {
    return p.heard_at + (may_listen(p) ? std::max(listener_stays, options_.timeout) : options_.timeout);
}

TimePoint PeerBook::next_look(TimePoint now) const noexcept {
    TimePoint next = TimePoint::max();
    for (const ChannelId id : used_) {
        const Peer& p = peer(id);
        if (p.is_gone) return now;
        next = std::min(next, is_silent(p, now) ? longest_stay(p) : p.heard_at + options_.timeout);
    }
    return next;
}

}  // namespace anogate
