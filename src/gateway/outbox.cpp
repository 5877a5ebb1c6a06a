#include <gateway/in_flight.hpp>
#include <gateway/outbox.hpp>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <type_traits>

namespace anogate {
namespace {

constexpr std::size_t urgent = static_cast<std::size_t>(TrafficClass::urgent);
constexpr std::size_t telemetry = static_cast<std::size_t>(TrafficClass::telemetry);
constexpr std::size_t bulk = static_cast<std::size_t>(TrafficClass::bulk);

// For each byte that a class sends while lower ones wait they may send a ninth: a tenth of all.
constexpr std::uint64_t bytes_before_one = 9;

// How many frames of one bucket are looked at: an attacker's choice of addresses must not make push() slow.
constexpr int longest_search = 16;

ano::Duration limit(const AgeLimits& limits, AgeKind kind) noexcept {
    switch (kind) {
        case AgeKind::control: return limits.control;
        case AgeKind::telemetry: return limits.telemetry;
        case AgeKind::rest: break;
    }
    return limits.rest;
}

std::uint32_t key_of(ano::FrameView frame, Replaces replaces) noexcept {
    const std::uint32_t first_byte = replaces == Replaces::same_first_byte ? frame.data()[0] : 0u;
    return static_cast<std::uint32_t>(frame.source() | frame.destination() << 8 | frame.id() << 16) | first_byte << 24;
}

}    // namespace

Outbox::Outbox(const Options& options)
    : options_{options},
      capacity_{2 * options.bytes},
      arena_{new std::uint8_t[capacity_]},
      entries_{new Entry[options.bytes / ano::overhead + 2]} {
    static_assert(std::is_trivially_default_constructible_v<Entry>);    // or all of them would be touched here
    assert(options.bytes >= ano::overhead + options.max_data && options.bytes <= std::size_t{1} << 30);
}

void Outbox::push(ano::FrameView frame, Treatment treatment, ano::TimePoint now) noexcept {
    store(frame, treatment, now + limit(options_.age, treatment.age));
}

void Outbox::store(ano::FrameView frame, Treatment treatment, ano::TimePoint stale_at) noexcept {
    const auto bytes = frame.bytes();
    if (!open_) return refuse(&SendCounters::link_down);
    if (bytes.size() > ano::overhead + options_.max_data) return refuse(&SendCounters::too_big);

    const bool congested = congested_;    // even if, for a moment, nothing waits
    const std::uint64_t number = ++pushed_;
    std::uint64_t turn = number;
    const bool replaceable = treatment.replaces == Replaces::same_id ||
                             (treatment.replaces == Replaces::same_first_byte && !frame.data().empty());
    const std::uint32_t key = replaceable ? key_of(frame, treatment.replaces) : 0;
    if (replaceable && congested) turn = std::min(turn, supersede(key));
    if (!make_room(bytes.size(), treatment.traffic)) return refuse(&SendCounters::queue_full);

    ++counters_.offered;
    const Index i = new_entry();
    Entry& entry = entries_[i];
    entry.at = static_cast<std::uint32_t>(end_);
    entry.size = static_cast<std::uint32_t>(bytes.size());
    entry.key = key;
    entry.traffic = treatment.traffic;
    entry.replaceable = replaceable;
    entry.number = number;
    entry.turn = turn;
    entry.stale_at = stale_at.time_since_epoch();
    std::memcpy(arena_.get() + end_, bytes.data(), bytes.size());
    end_ += bytes.size();
    bytes_ += bytes.size();
    ++frames_;
    congested_ = congested;

    const auto traffic = static_cast<std::size_t>(treatment.traffic);
    queued_bytes_[traffic] += bytes.size();
    append<&Entry::in_class>(queues_[traffic], i);
    append<&Entry::in_arena>(in_arena_, i);
    if (replaceable) append<&Entry::in_bucket>(bucket(key), i);
    if (in_flight_) in_flight_->queued(frame);
}

Outbox::Next Outbox::next(ano::TimePoint now) noexcept {
    Schedule plan = schedule();
    drop_stale(plan, now);
    const bool urgent_waits = plan.next[urgent] != none;
    if (begun_ != none)
        return {entries_[begun_].size - partly_sent_, urgent_waits || entries_[begun_].traffic == TrafficClass::urgent};
    const std::size_t traffic = choose(plan);
    return {traffic < traffic_classes ? entries_[plan.next[traffic]].size : 0, urgent_waits};
}

std::size_t Outbox::gather(std::span<std::span<const std::uint8_t>> pieces, ano::TimePoint now,
                           std::size_t budget) noexcept {
    gathered_at_ = now;
    std::size_t count = 0;
    std::size_t total = 0;
    const auto give = [&](const Entry& entry, std::size_t from) {
        pieces[count++] = {arena_.get() + entry.at + from, entry.size - from};
        total += entry.size - from;
    };
    if (begun_ != none && !pieces.empty()) give(entries_[begun_], partly_sent_);
    Schedule plan = schedule();
    while (count < pieces.size()) {
        drop_stale(plan, now);
        const std::size_t traffic = choose(plan);
        if (traffic == traffic_classes) break;
        const Entry& entry = entries_[plan.next[traffic]];
        if (total + entry.size > budget) break;
        give(entry, 0);
        advance(plan, traffic);
    }
    return count;
}

void Outbox::sent(std::size_t bytes) noexcept {
    assert(bytes <= bytes_ - partly_sent_);
    while (bytes > 0 && frames_ > 0) {
        if (begun_ == none) begun_ = take_first();
        const std::size_t rest = entries_[begun_].size - partly_sent_;
        if (bytes < rest) {
            partly_sent_ += bytes;
            return;
        }
        bytes -= rest;
        sent_frame();
    }
}

void Outbox::sent_frame() noexcept {
    assert(frames_ > 0);
    const Index i = begun_ != none ? begun_ : take_first();
    ++counters_.frames_out;
    counters_.bytes_out += entries_[i].size;
    if (entries_[i].size == ano::overhead) ++counters_.empty_out;
    if (in_flight_) in_flight_->left(view(i), gathered_at_);
    begun_ = none;
    partly_sent_ = 0;
    release(i);
}

void Outbox::drop_frame(std::uint64_t SendCounters::*cause) noexcept {
    assert(frames_ > 0 && begun_ == none);    // the receiver would take what follows for the rest of it
    ++(counters_.*cause);
    const Index i = take_first();
    if (in_flight_) in_flight_->dropped(view(i));
    release(i);
}

void Outbox::close() noexcept {
    open_ = false;
    counters_.link_down += frames_;
    queues_ = {};
    buckets_ = {};
    in_arena_ = {};
    queued_bytes_ = {};
    begun_ = free_ = none;
    partly_sent_ = frames_ = bytes_ = end_ = used_ = 0;
    owed_ = {};
    congested_ = false;
}

// Takes out the newest frame of this key and returns its turn; else UINT64_MAX. One whose turn has come, since all that
// waited when its kind began to wait has left, is not replaced: or a kind that comes often would go to the end of the
// queue for ever.
std::uint64_t Outbox::supersede(std::uint32_t key) noexcept {
    Index i = bucket(key).last;
    for (int looked = 0; i != none && entries_[i].key != key; i = entries_[i].in_bucket.before)
        if (++looked == longest_search) return UINT64_MAX;
    if (i == none) return UINT64_MAX;
    const std::uint64_t turn = entries_[i].turn;
    const List& queue = queues_[static_cast<std::size_t>(entries_[i].traffic)];
    if (entries_[queue.first].number > turn && queue.first != queue.last) return UINT64_MAX;
    drop(i, &SendCounters::superseded);
    return turn;
}

// False: the frame itself has to go. One that has begun to leave stands above the bound when nothing else is left to
// drop.
bool Outbox::make_room(std::size_t size, TrafficClass traffic) noexcept {
    const std::size_t begun = begun_ != none ? entries_[begun_].size : 0;
    const std::size_t higher =
        bytes_ - begun - queued_below(traffic) - queued_bytes_[static_cast<std::size_t>(traffic)];
    if (higher > 0 && size > reserve() && higher + begun + size > options_.bytes) return false;
    while (bytes_ + size > options_.bytes && bytes_ > begun)
        drop(queues_[gives_way(size, traffic)].first, &SendCounters::queue_full);
    if (end_ + size > capacity_) compact();
    return true;
}

// Which class drops its oldest for a new frame: the lowest, but none is pushed under a tenth of the bound by higher
// ones.
std::size_t Outbox::gives_way(std::size_t size, TrafficClass traffic) const noexcept {
    const auto own = static_cast<std::size_t>(traffic);
    for (std::size_t t = 0; t <= own; ++t) {
        const std::size_t below = queued_below(static_cast<TrafficClass>(t)) + (t < own ? size : 0);
        if (queues_[t].first != none && below <= reserve()) return t;
    }
    std::size_t lowest = bulk;
    while (queues_[lowest].first == none) --lowest;
    return lowest;
}

std::size_t Outbox::queued_below(TrafficClass traffic) const noexcept {
    std::size_t bytes = 0;
    for (std::size_t t = static_cast<std::size_t>(traffic) + 1; t < traffic_classes; ++t) bytes += queued_bytes_[t];
    return bytes;
}

void Outbox::compact() noexcept {
    std::size_t to = 0;
    for (Index i = in_arena_.first; i != none; i = entries_[i].in_arena.behind) {
        Entry& entry = entries_[i];
        std::memmove(arena_.get() + to, arena_.get() + entry.at, entry.size);
        entry.at = static_cast<std::uint32_t>(to);
        to += entry.size;
    }
    end_ = to;
}

Outbox::Index Outbox::new_entry() noexcept {
    if (free_ == none) return used_++;
    const Index i = free_;
    free_ = entries_[i].in_class.behind;
    return i;
}

void Outbox::unqueue(Index i) noexcept {
    const Entry& entry = entries_[i];
    const auto traffic = static_cast<std::size_t>(entry.traffic);
    queued_bytes_[traffic] -= entry.size;
    unlink<&Entry::in_class>(queues_[traffic], i);
    if (entry.replaceable) unlink<&Entry::in_bucket>(bucket(entry.key), i);
}

// `i` stands in no queue any more.
void Outbox::release(Index i) noexcept {
    unlink<&Entry::in_arena>(in_arena_, i);
    bytes_ -= entries_[i].size;
    entries_[i].in_class.behind = free_;
    free_ = i;
    if (--frames_ > 0) return;
    free_ = none;
    used_ = 0;
    end_ = 0;
    owed_ = {};
    congested_ = false;
}

void Outbox::drop(Index i, std::uint64_t SendCounters::*cause) noexcept {
    ++(counters_.*cause);
    if (in_flight_) in_flight_->dropped(view(i));
    unqueue(i);
    release(i);
}

void Outbox::drop_stale(Schedule& plan, ano::TimePoint now) noexcept {
    for (Index& next : plan.next) {
        while (next != none && entries_[next].stale_at <= now.time_since_epoch()) {
            const Index stale = next;
            next = entries_[stale].in_class.behind;
            drop(stale, &SendCounters::stale);
        }
    }
}

Outbox::Schedule Outbox::schedule() const noexcept {
    return {{queues_[urgent].first, queues_[telemetry].first, queues_[bulk].first}, owed_};
}

// The class that sends next; traffic_classes when nothing waits.
std::size_t Outbox::choose(const Schedule& plan) const noexcept {
    std::size_t chosen = traffic_classes;
    for (std::size_t t = traffic_classes; t-- > 0;) {
        if (plan.next[t] == none) continue;
        const bool lower_is_due =
            chosen < traffic_classes && plan.owed[t] >= bytes_before_one * entries_[plan.next[chosen]].size;
        if (!lower_is_due) chosen = t;
    }
    return chosen;
}

// The first frame of `traffic` leaves.
void Outbox::advance(Schedule& plan, std::size_t traffic) const noexcept {
    const Entry& entry = entries_[plan.next[traffic]];
    for (std::size_t above = 0; above < traffic; ++above)
        plan.owed[above] -= std::min(plan.owed[above], bytes_before_one * entry.size);
    bool lower_waits = false;
    for (std::size_t below = traffic + 1; below < traffic_classes; ++below) lower_waits |= plan.next[below] != none;
    if (lower_waits)
        plan.owed[traffic] += entry.size;
    else if (traffic < plan.owed.size())
        plan.owed[traffic] = 0;
    plan.next[traffic] = entry.in_class.behind;
}

Outbox::Index Outbox::take_first() noexcept {
    Schedule plan = schedule();
    const std::size_t traffic = choose(plan);
    const Index i = plan.next[traffic];
    advance(plan, traffic);
    owed_ = plan.owed;
    unqueue(i);
    return i;
}

template <Outbox::Neighbours Outbox::Entry::*in>
void Outbox::append(List& list, Index i) noexcept {
    (entries_[i].*in) = {list.last, none};
    if (list.last == none)
        list.first = i;
    else
        (entries_[list.last].*in).behind = i;
    list.last = i;
}

template <Outbox::Neighbours Outbox::Entry::*in>
void Outbox::unlink(List& list, Index i) noexcept {
    const Neighbours at = entries_[i].*in;
    if (at.before == none)
        list.first = at.behind;
    else
        (entries_[at.before].*in).behind = at.behind;
    if (at.behind == none)
        list.last = at.before;
    else
        (entries_[at.behind].*in).before = at.before;
}

}    // namespace anogate
