#include <ano/address.hpp>
#include <gateway/peers/peer_book.hpp>

#include <algorithm>
#include <tuple>
#include <utility>

namespace anogate {

PeerBook::Place PeerBook::place_for(const Endpoint& stranger, TimePoint now, Rank rank, bool commands) {
    const IpAddress& address = stranger.address;
    const bool local = address.is_loopback();
    const std::size_t of_address = places_of(address, rank);
    commands = commands || rank == Rank::commands;
    const bool address_full = !local && of_address + (commands ? 0 : kept_of_address(address)) >= options_.max_of_address;
    if (!address_full && has_free_place(rank)) return {true, std::nullopt};

    const bool again = keeps_retrying(stranger, now);
    const ChannelSet late = options_.has_connections ? overdue(now) : ChannelSet{};
    std::optional<ChannelId> replaced;
    for (const ChannelId id : used_) {
        const Peer& p = peer(id);
        if (options_.has_connections && p.rank > rank && p.rank == Rank::trusted) continue;    // its address can't be forged
        if (address_full ? !may_leave_for_party(p, address, rank) : !may_be_evicted(p, rank)) continue;
        const bool has_more = address_full || places_of(p.endpoint.address, rank) > of_address + 1;
        const bool sent_once = !p.has_returned && (has_more || (now - p.heard_at >= exchange && !may_listen(p)));
        const bool is_evictable = is_silent(p, now) ? again || !p.has_returned : again && sent_once;
        const bool is_former = address_full && again && !may_listen(p) && !has_commanded(p) && now - p.heard_at >= once_stays;
        const bool is_of_us = local && p.endpoint.address.is_loopback() && (again || !p.has_returned);
        if (!is_evictable && !is_former && !is_of_us && !late.contains(id)) continue;
        if (!replaced || leaves_before(p, peer(*replaced))) replaced = id;
    }
    if (!replaced && commands && options_.kept > 0) {
        const auto by_command = replaced_by_command(rank, address_full ? &address : nullptr, now);
        if (by_command && takes_turn(now)) replaced = by_command;
    }
    return {replaced.has_value(), replaced};
}

// A host that commanded leaves only for its own address, and the last one there not for one that does not command.
bool PeerBook::may_leave_for_party(const Peer& p, const IpAddress& address, Rank rank) const noexcept {
    if (!is_same_party(p.endpoint.address, address, rank)) return false;
    if (p.rank <= rank) return true;
    const auto commands_here = [&](ChannelId id) { return peer(id).rank > rank && peer(id).endpoint.address == address; };
    std::size_t commanding = 0;
    for (const ChannelId id : used_) commanding += commands_here(id);
    return p.endpoint.address == address && commanding > 1;
}

// One that sent once leaves before one that sent again, and of these the longest silent.
bool PeerBook::leaves_before(const Peer& a, const Peer& b) noexcept {
    return std::pair{a.has_returned, a.heard_at} < std::pair{b.has_returned, b.heard_at};
}

// One place of an address, if no host there commands: others do not use it.
std::size_t PeerBook::kept_of_address(const IpAddress& address) const noexcept {
    if (options_.kept == 0 || options_.max_of_address < 2) return 0;
    for (const ChannelId id : used_)
        if (has_commanded(peer(id)) && peer(id).endpoint.address == address) return 0;
    return 1;
}

std::optional<ChannelId> PeerBook::replaced_by_command(Rank rank, const IpAddress* of, TimePoint now) const noexcept {
    std::optional<ChannelId> last, before;    // of those that joined
    const auto joined_later = [&](ChannelId id, const std::optional<ChannelId>& than) {
        return !than || peer(id).exchange_began >= peer(*than).exchange_began;
    };
    for (const ChannelId id : used_) {
        const Peer& p = peer(id);
        const bool may_leave = of ? p.rank <= rank && p.endpoint.address == *of : p.rank == Rank::commands;
        if (!may_leave || !has_commanded(p)) continue;
        if (joined_later(id, last)) before = std::exchange(last, id);
        else if (joined_later(id, before)) before = id;
    }
    if (!last) return std::nullopt;
    const auto between_commands = [&](const Peer& p) {
        return std::max(p.commanded_at - p.commanded_before, now - p.commanded_at);
    };
    if (before && between_commands(peer(*before)) > between_commands(peer(*last))) last = before;
    return last;
}

bool PeerBook::takes_turn(TimePoint now) noexcept {
    const TimePoint until = std::max(turns_used_until_, now) + turn;
    if (until > now + turns_at_once * turn) return false;
    turns_used_until_ = until;
    return true;
}

void PeerBook::remember_displaced(const Peer& p) noexcept {
    Displaced* row = displaced_.data();
    for (Displaced& displaced : displaced_) {
        if (displaced.endpoint == p.endpoint) {
            row = &displaced;
            break;
        }
        if (displaced.commanded_at < row->commanded_at) row = &displaced;
    }
    *row = {p.endpoint, p.commanded_at};
}

void PeerBook::commanded(ChannelId id, TimePoint now) noexcept {
    Peer& p = peer(id);
    p.rank = std::max(p.rank, Rank::commands);
    if (now > p.commanded_at) p.commanded_before = std::exchange(p.commanded_at, now);
}

bool PeerBook::has_free_place(Rank rank) const noexcept {
    const auto owed = [&](std::size_t kept, Rank to) { return kept - std::min(kept, count(to)); };
    std::size_t kept = 0;
    if (rank == Rank::ordinary) kept = owed(options_.kept, Rank::commands);
    if (rank < Rank::trusted) kept = std::max(kept, owed(options_.kept_for_trusted, Rank::trusted));
    return used_.size() + kept < options_.max_peers;
}

// The number of peers of higher ranks must not fall below their reserve.
bool PeerBook::may_be_evicted(const Peer& p, Rank to) const noexcept {
    if (p.rank <= to) return true;
    if (p.rank == Rank::trusted && count(Rank::trusted) <= options_.kept_for_trusted) return false;
    return to != Rank::ordinary || count(Rank::commands) > options_.kept;
}

std::size_t PeerBook::count(Rank at_least) const noexcept {
    std::size_t count = 0;
    for (const ChannelId id : used_)
        if (peer(id).rank >= at_least) ++count;
    return count;
}

std::size_t PeerBook::places_of(const IpAddress& address, Rank rank) const noexcept {
    std::size_t count = 0;
    for (const ChannelId id : used_)
        if (is_same_party(peer(id).endpoint.address, address, rank)) ++count;
    return count;
}

// A network may have many hosts: strangers there can't use up the share of those that command or are trusted.
bool PeerBook::is_same_party(const IpAddress& a, const IpAddress& b, Rank rank) const noexcept {
    constexpr std::size_t network = 8;    // bytes
    if (!options_.has_connections || rank != Rank::ordinary || !a.v6 || !b.v6 || a.is_loopback() || b.is_loopback())
        return a == b;
    return std::equal(a.bytes.begin(), a.bytes.begin() + network, b.bytes.begin());
}

// Senders of single datagrams replace each other. One that sends again keeps its row for twice the time that it has been sending,
// at least for `kept_row` and at most for an exchange: two datagrams in quick succession keep it only briefly, and two senders of one
// row don't take it from each other.
bool PeerBook::keeps_retrying(const Endpoint& stranger, TimePoint now) noexcept {
    RejectedSender& row = row_of(stranger);
    const bool is_known = row.endpoint == stranger;
    if (!is_known && now - row.last < std::clamp<Duration>(2 * (row.last - row.first), kept_row, exchange)) return false;
    if (!is_known || now - row.last >= options_.timeout) row = {stranger, now, now};
    row.last = now;
    return row.has_returned();
}

// An address other than loopback has only two rows, so that it can't replace the senders of all others.
PeerBook::RejectedSender& PeerBook::row_of(const Endpoint& stranger) noexcept {
    constexpr std::uint64_t factor = 0x9E3779B97F4A7C15;    // odd and irregular: the upper bits of a product depend on all bits
    std::uint64_t hash = options_.seed + (stranger.address.is_loopback() ? stranger.port : stranger.port % 2u);
    for (const std::uint8_t byte : stranger.address.bytes) hash = (hash ^ hash >> 32 ^ byte) * factor;
    return rejected_[(hash >> 32) % rejected_.size()];
}

void PeerBook::add(ChannelId id, const Endpoint& endpoint, bool near, TimePoint now, Rank rank) {
    used_.insert(id);
    peer(id) = {};
    peer(id).endpoint = endpoint;
    peer(id).near = near;
    peer(id).rank = rank;
    peer(id).heard_at = now;
    peer(id).exchange_began = now;
    const RejectedSender& rejected = row_of(endpoint);
    if (rejected.endpoint == endpoint && rejected.last == now && rejected.has_returned()) {
        peer(id).has_returned = true;
        peer(id).once = false;
    }
    for (const Displaced& displaced : displaced_)
        if (displaced.endpoint == endpoint) peer(id).commanded_at = displaced.commanded_at;
}

void PeerBook::remove(ChannelId id) noexcept {
    if (used_.contains(id) && peer(id).rank == Rank::commands) remember_displaced(peer(id));
    used_.erase(id);
}

void PeerBook::heard(ChannelId id, std::uint8_t source, TimePoint now) noexcept {
    Peer& p = peer(id);
    p.heard_at = now;
    p.has_returned = p.has_returned || now - p.exchange_began >= exchange;
    p.is_host = p.is_host || ano::address::is_host(source);
    p.refusals = 0;
    p.is_gone = false;
}

PeerBook::Memory PeerBook::memory(ChannelId id) const noexcept {
    const Peer& p = peer(id);
    return {p.heard_at, p.is_host, p.has_returned, p.once, p.rank == Rank::commands};
}

void PeerBook::remember(ChannelId id, const Memory& memory) noexcept {
    Peer& p = peer(id);
    p.heard_at = p.exchange_began = memory.heard_at;
    p.is_host = memory.is_host;
    p.has_returned = memory.has_returned;
    p.once = memory.once;
    if (memory.commands) commanded(id, memory.heard_at);
}

bool PeerBook::refused(ChannelId id, TimePoint now) noexcept {
    Peer& p = peer(id);
    if (p.refusals == 0) p.first_refused_at = now;
    ++p.refusals;
    p.is_gone = p.is_gone || p.once || (p.refusals >= enough_refusals && now - p.first_refused_at >= refused_for);
    return p.is_gone;
}

std::optional<ChannelId> PeerBook::longest_silent(Rank to, TimePoint now) const noexcept {
    std::optional<ChannelId> longest;
    for (const ChannelId id : to == Rank::ordinary ? overdue(now) : used_) {
        const Peer& p = peer(id);
        if (p.rank != Rank::ordinary || (!p.is_host && now - p.heard_at < device_is_active)) continue;
        if (!longest || leaves_before(p, peer(*longest))) longest = id;
    }
    return longest;
}

ChannelSet PeerBook::overdue(TimePoint now) const noexcept {
    ChannelSet result;
    for (const ChannelId id : used_)
        if (is_overdue(id, now)) result.insert(id);
    return result;
}

bool PeerBook::is_overdue(ChannelId id, TimePoint now) const noexcept {
    const Peer& p = peer(id);
    if (p.is_gone || now >= max_stay(p)) return true;
    return listens(p, now) && (exceeds_address(id, now) || exceeds_listeners(id, now));
}

// Of the hosts of an address that only receive, two stay: the latest, and of the others one that sent again before those that sent
// once, and of these the latest.
bool PeerBook::exceeds_address(ChannelId id, TimePoint now) const noexcept {
    const IpAddress& address = peer(id).endpoint.address;
    const auto first = [&](std::optional<ChannelId> except) {
        std::optional<ChannelId> best;
        const auto key = [&](ChannelId one) {
            return std::tuple{except && peer(one).has_returned, peer(one).heard_at, index(one)};
        };
        for (const ChannelId one : used_)
            if (one != except && peer(one).endpoint.address == address && listens(peer(one), now) &&
                (!best || key(one) > key(*best)))
                best = one;
        return best;
    };
    const auto latest = first(std::nullopt);
    return id != latest && id != first(latest);
}

// Whether max_listeners others that sent in one exchange only receive and precede it: those of a higher rank, and of its own the
// earlier ones, which a new one must not replace.
bool PeerBook::exceeds_listeners(ChannelId id, TimePoint now) const noexcept {
    const Peer& p = peer(id);
    if (p.has_returned || p.endpoint.address.is_loopback()) return false;
    std::size_t earlier = 0;
    for (const ChannelId other : used_) {
        const Peer& o = peer(other);
        if (o.has_returned || o.endpoint.address.is_loopback() || !listens(o, now) || exceeds_address(other, now)) continue;
        const bool is_earlier = o.heard_at < p.heard_at || (o.heard_at == p.heard_at && index(other) < index(id));
        if (o.rank > p.rank || (o.rank == p.rank && is_earlier)) ++earlier;
    }
    return earlier >= max_listeners;
}

Duration PeerBook::patience(const Peer& p) const noexcept {
    const bool is_checked = p.near || options_.has_connections;
    const bool is_brief = may_listen(p) ? !p.has_returned : p.once;
    const bool leaves_early = is_brief && is_checked && !(may_listen(p) && p.endpoint.address.is_loopback());
    return leaves_early ? std::min(once_stays, options_.timeout) : options_.timeout;
}

TimePoint PeerBook::max_stay(const Peer& p) const noexcept {
    return p.heard_at + (may_listen(p) ? std::max(listener_stays, options_.timeout) : patience(p));
}

TimePoint PeerBook::next_look(TimePoint now) const noexcept {
    TimePoint next = TimePoint::max();
    for (const ChannelId id : used_) {
        const Peer& p = peer(id);
        if (p.is_gone) return now;
        const TimePoint due = p.heard_at + patience(p);
        next = std::min(next, now >= due ? max_stay(p) : due);
    }
    return next;
}

std::optional<TimePoint> PeerBook::listening_since(ChannelId id) const noexcept {
    const Peer& p = peer(id);
    return p.once && may_listen(p) ? std::optional{p.heard_at} : std::nullopt;
}

bool can_be_peer(const Endpoint& sender, const std::vector<Network>& own) noexcept {
    return sender.port != 0 && !sender.address.is_any() && !sender.address.is_multicast() && !is_broadcast(sender.address, own);
}

}    // namespace anogate
