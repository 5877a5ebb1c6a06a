#include <gateway/in_flight.hpp>
#include <gateway/outbox.hpp>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace anogate {
namespace {

constexpr std::size_t urgent = static_cast<std::size_t>(TrafficClass::urgent);

// The bytes of a turn, by class. Urgent frames take turns one by one: their number is below the smallest frame.
constexpr std::array<std::int32_t, traffic_classes> quanta{ano::overhead, 32, 256};

// Maximum number of frames of one bucket that are searched: addresses chosen by an attacker must not make push() slow.
constexpr int max_entries_searched = 16;

constexpr std::array<std::uint8_t, Outbox::max_flush> zero_bytes{};

std::uint32_t replacement_key(ano::FrameView frame, Replaces replaces) noexcept {
    const std::uint32_t first_byte = replaces == Replaces::same_first_byte ? frame.data()[0] : 0u;
    return static_cast<std::uint32_t>(frame.source() | frame.destination() << 8 | frame.id() << 16) | first_byte << 24;
}

}    // namespace

Outbox::Outbox(const Options& options)
    : options_{options},
      capacity_{2 * options.bytes},
      arena_{capacity_},
      entries_{options.bytes / ano::overhead + 2},
      queues_{FairQueue{entries_.get(), options.bytes / ano::overhead + 2, quanta[0]},
              FairQueue{entries_.get(), options.bytes / ano::overhead + 2, quanta[1]},
              FairQueue{entries_.get(), options.bytes / ano::overhead + 2, quanta[2]}} {
    buckets_.fill(no_frames);
    assert(options.bytes >= ano::overhead + options.max_data && options.bytes <= std::size_t{1} << 30);
    assert(options.flush_bytes <= max_flush);
}

SendCause Outbox::push(ano::FrameView frame, QueuePolicy policy, ano::TimePoint arrived_at, ChannelId from) noexcept {
    return store(frame, policy, arrived_at + limit(options_.age, policy), from);
}

bool Outbox::is_stale(QueuePolicy policy, ano::Duration age) const noexcept { return age >= limit(options_.age, policy); }

void Outbox::grow_older(ano::Duration time) noexcept {
    for (Index i = in_arena_.first; i != none; i = entries_[i].in_arena.behind)
        if (entries_[i].stale_at != ano::Duration::max()) entries_[i].stale_at -= time;
}

bool Outbox::flush_parser(ano::TimePoint now) noexcept {
    if (!open_ || !empty() || options_.flush_bytes == 0 || now < flush_again_at_) return false;
    zeros_ = options_.flush_bytes;
    zeros_before_ = pushed_ + 1;
    flush_again_at_ = now + between_flushes;
    return true;
}

ano::Duration Outbox::until_flush(ano::TimePoint now) const noexcept {
    if (!open_ || !empty() || options_.flush_bytes == 0 || now >= flush_again_at_) return {};
    return flush_again_at_ - now;
}

bool Outbox::has_waiting(ChannelId from) const noexcept {
    for (Index i = in_arena_.first; i != none; i = entries_[i].in_arena.behind)
        if (i != begun_ && queues_[entries_[i].traffic].channel_of(i) == from) return true;
    return false;
}

SendCause Outbox::store(ano::FrameView frame, QueuePolicy policy, ano::TimePoint stale_at, ChannelId from) noexcept {
    const auto bytes = frame.bytes();
    if (!open_) return refuse(&SendCounters::link_down);
    if (bytes.size() > std::min(ano::overhead + ano::max_data_of(frame.id(), options_.max_data), options_.bytes))
        return refuse(&SendCounters::too_big);

    const bool congested = congested_;    // also if the outbox is empty for a moment below
    const std::uint64_t number = ++pushed_;
    std::uint64_t turn = number;
    const bool replaceable = policy.replaces == Replaces::same_id ||
                             (policy.replaces == Replaces::same_first_byte && !frame.data().empty());
    const std::uint32_t key = replaceable ? replacement_key(frame, policy.replaces) : 0;
    if (replaceable && congested) turn = std::min(turn, supersede(key, from));
    if (!make_room(bytes.size(), policy.traffic)) return refuse(&SendCounters::queue_full);

    ++counters_.offered;
    if (number > zeros_before_) zeros_ = 0;    // no frame waits for more than one frame after them
    const Index i = new_entry();
    WaitingFrame& entry = entries_[i];
    entry.at = static_cast<std::uint32_t>(end_);
    entry.key = key;
    entry.size = static_cast<std::uint32_t>(bytes.size()) & 0xFFFFFFFu;
    entry.traffic = static_cast<std::uint32_t>(policy.traffic) & 3u;
    entry.replaceable = replaceable;
    entry.overtakes = policy.age == AgeKind::control;
    entry.number = number;
    entry.turn = turn;
    entry.stale_at = stale_at.time_since_epoch();
    std::memcpy(arena_.get() + end_, bytes.data(), bytes.size());
    end_ += bytes.size();
    bytes_ += bytes.size();
    ++frames_;
    congested_ = congested;

    queues_[static_cast<std::size_t>(policy.traffic)].push(i, from, frame.source());
    waiting_classes_ |= 1u << static_cast<std::size_t>(policy.traffic);
    append<&WaitingFrame::in_arena>(entries_.get(), in_arena_, i);
    if (replaceable) append<&WaitingFrame::in_bucket>(entries_.get(), bucket(key, from), i);
    if (in_flight_) in_flight_->queued(frame, from);
    return nullptr;
}

Outbox::Next Outbox::next(ano::TimePoint now) noexcept {
    const Schedule first = plan(now);
    const bool urgent_waits = first.next[urgent] != none;
    if (zeros_ > 0) return {std::min(zeros_, zeros_at_once), urgent_waits, true};
    if (begun_ != none) return {entries_[begun_].size - partly_sent_, urgent_waits || entries_[begun_].traffic == urgent};
    const std::size_t traffic = first.shares.choose(first.sizes);
    return {traffic < traffic_classes ? first.sizes[traffic] : 0, urgent_waits};
}

std::size_t Outbox::gather(std::span<std::span<const std::uint8_t>> pieces, ano::TimePoint now, std::size_t budget) noexcept {
    gathered_at_ = now;
    std::size_t count = 0;
    std::size_t total = 0;
    const auto append_piece = [&](const WaitingFrame& entry, std::size_t from) {
        pieces[count++] = {arena_.get() + entry.at + from, entry.size - from};
        total += entry.size - from;
    };
    if (zeros_ > 0 && !pieces.empty()) {
        total = std::min(zeros_, budget);
        if (total == 0) return 0;
        pieces[count++] = std::span{zero_bytes}.first(total);
        if (total < zeros_) return count;
    }
    if (begun_ != none && !pieces.empty()) append_piece(entries_[begun_], partly_sent_);
    if (count == pieces.size()) return count;
    if (const FairQueue* queue = in_order()) {
        for (Index i = queue->front(); i != none && count < pieces.size();) {
            const WaitingFrame& entry = entries_[i];
            const Index behind = entry.in_flow.behind;
            if (entry.stale_at <= now.time_since_epoch()) drop(i, &SendCounters::stale);
            else if (total + entry.size <= budget) append_piece(entry, 0);
            else break;
            i = behind;
        }
        return count;
    }
    for (Schedule schedule = plan(now);;) {
        const std::size_t traffic = schedule.shares.choose(schedule.sizes);
        if (traffic == traffic_classes) break;
        const WaitingFrame& entry = entries_[schedule.next[traffic]];
        if (total + entry.size > budget) break;
        append_piece(entry, 0);
        schedule.shares.leaves(traffic, schedule.sizes);
        queues_[traffic].pop_planned();
        if (count == pieces.size()) break;
        look_at(schedule, traffic, now);
    }
    return count;
}

void Outbox::sent(std::size_t bytes) noexcept {
    assert(bytes <= zeros_ + bytes_ - partly_sent_);
    const std::size_t zeros = std::min(bytes, zeros_);
    zeros_ -= zeros;
    counters_.flush_bytes += zeros;
    bytes -= zeros;
    while (bytes > 0 && frames_ > 0) {
        if (begun_ == none) begun_ = pop_first_frame();
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
    const Index i = begun_ != none ? begun_ : pop_first_frame();
    ++counters_.frames_out;
    counters_.bytes_out += entries_[i].size;
    if (entries_[i].size == ano::overhead) ++counters_.empty_out;
    if (watch_) [[unlikely]]
        watch_->left(watched_as_, view(i));
    if (in_flight_) in_flight_->left(view(i), gathered_at_);
    begun_ = none;
    partly_sent_ = 0;
    release(i);
    if (empty()) shares_.clear();
}

void Outbox::drop_frame(SendCause cause) noexcept {
    assert(frames_ > 0 && begun_ == none);    // otherwise the receiver would read the next frame as the rest of this one
    ++(counters_.*cause);
    const Index i = pop_first_frame();
    if (in_flight_) in_flight_->dropped(view(i));
    report_dropped(view(i), cause);
    release(i);
    if (empty()) shares_.clear();
}

void Outbox::drop_waiting(SendCause cause) noexcept {
    zeros_ = 0;
    for (Index i = in_arena_.first; i != none;) {
        const Index behind = entries_[i].in_arena.behind;
        if (i != begun_) drop(i, cause);
        i = behind;
    }
    if (empty()) shares_.clear();
}

void Outbox::close() noexcept {
    open_ = false;
    counters_.link_down += frames_;
    for (Index i = watch_ ? in_arena_.first : none; i != none; i = entries_[i].in_arena.behind)
        report_dropped(view(i), &SendCounters::link_down);
    for (FairQueue& queue : queues_) queue.clear();
    buckets_.fill(no_frames);
    in_arena_ = no_frames;
    begun_ = free_ = none;
    partly_sent_ = frames_ = bytes_ = zeros_ = end_ = used_ = 0;
    shares_.clear();
    waiting_classes_ = 0;
    congested_ = false;
}

// Removes the newest frame of this key from the same channel, and returns its turn; UINT64_MAX: there is none. A frame is not
// replaced when its turn has come: its sender has sent all frames that waited before the first frame of this key. Otherwise a
// frequent kind would be moved to the end again and again, and never sent.
std::uint64_t Outbox::supersede(std::uint32_t key, ChannelId from) noexcept {
    const auto same = [&](Index i) { return entries_[i].key == key && queues_[entries_[i].traffic].channel_of(i) == from; };
    Index i = bucket(key, from).last;
    for (int looked = 0; i != none && !same(i); i = entries_[i].in_bucket.before)
        if (++looked == max_entries_searched) return UINT64_MAX;
    if (i == none) return UINT64_MAX;
    const std::uint64_t turn = entries_[i].turn;
    const FrameList& line = queues_[entries_[i].traffic].line_of(i);
    if (entries_[line.first].number > turn && line.first != line.last) return UINT64_MAX;
    drop(i, &SendCounters::superseded);
    return turn;
}

// After a pause, several arrive at once: the newest one counts, and would be too old at the end of the others. The queue is
// searched once each time that it becomes congested.
void Outbox::supersede_setpoints() noexcept {
    for (Index i = in_arena_.first, behind; i != none; i = behind) {
        WaitingFrame& older = entries_[i];
        behind = older.in_arena.behind;
        if (i == begun_ || !older.replaceable || !older.overtakes) continue;
        const auto is_newer = [&](Index n) {
            return entries_[n].key == older.key && entries_[n].overtakes && entries_[n].traffic == older.traffic &&
                   queues_[entries_[n].traffic].channel_of(n) == queues_[older.traffic].channel_of(i);
        };
        Index newer = older.in_bucket.behind;
        for (int looked = 1; newer != none && looked < max_entries_searched && !is_newer(newer); ++looked)
            newer = entries_[newer].in_bucket.behind;
        if (newer == none || !is_newer(newer)) continue;
        entries_[newer].turn = std::min(entries_[newer].turn, older.turn);
        drop(i, &SendCounters::superseded);
    }
}

// False: the new frame itself is dropped. A partly sent frame may exceed the limit if nothing else is left to drop.
bool Outbox::make_room(std::size_t size, TrafficClass traffic) noexcept {
    const std::size_t begun = begun_ != none ? entries_[begun_].size : 0;
    const auto own = static_cast<std::size_t>(traffic);
    if (bytes_ + size > options_.bytes) {
        const bool may_push_out = entitled(queues_[own], size);
        std::size_t higher = 0;
        for (std::size_t t = 0; t < own; ++t) higher += queues_[t].bytes();
        if (!may_push_out && higher > 0 && begun + higher + size > options_.bytes) return false;
        while (bytes_ + size > options_.bytes && bytes_ > begun)
            drop(queues_[next_evicted(own, may_push_out)].next_evicted(), &SendCounters::queue_full);
    }
    if (end_ + size > capacity_) compact();
    return true;
}

// The class that drops a frame to make room for one of the class `own`: the lowest that has more than its reserve. `entitled`:
// `own` has not used up its reserve, so that higher classes drop frames as well.
std::size_t Outbox::next_evicted(std::size_t own, bool entitled) const noexcept {
    for (std::size_t t = traffic_classes; t-- > (entitled ? 0 : own);)
        if (t == own ? !entitled && !queues_[t].empty() : has_more(queues_[t])) return t;
    std::size_t lowest = traffic_classes - 1;
    while (queues_[lowest].empty()) --lowest;
    return lowest;
}

bool Outbox::entitled(const FairQueue& queue, std::size_t more) const noexcept {
    return queue.bytes() + more <= (queue.empty() ? options_.bytes / 4 : options_.bytes / 10);
}

bool Outbox::has_more(const FairQueue& queue) const noexcept {
    return queue.bytes() > (queue.count() == 1 ? options_.bytes / 4 : options_.bytes / 10);
}

void Outbox::compact() noexcept {
    std::size_t to = 0;
    for (Index i = in_arena_.first; i != none; i = entries_[i].in_arena.behind) {
        WaitingFrame& entry = entries_[i];
        std::memmove(arena_.get() + to, arena_.get() + entry.at, entry.size);
        entry.at = static_cast<std::uint32_t>(to);
        to += entry.size;
    }
    end_ = to;
}

Outbox::Index Outbox::new_entry() noexcept {
    if (free_ == none) return used_++;
    const Index i = free_;
    free_ = entries_[i].in_flow.behind;
    return i;
}

void Outbox::leave_bucket(Index i) noexcept {
    const WaitingFrame& entry = entries_[i];
    if (!entry.replaceable) return;
    unlink<&WaitingFrame::in_bucket>(entries_.get(), bucket(entry.key, queues_[entry.traffic].channel_of(i)), i);
}

// Frees the entry of a frame, which must have been removed from its queue.
void Outbox::release(Index i) noexcept {
    unlink<&WaitingFrame::in_arena>(entries_.get(), in_arena_, i);
    bytes_ -= entries_[i].size;
    entries_[i].in_flow.behind = free_;
    free_ = i;
    if (--frames_ > 0) return;
    free_ = none;
    used_ = 0;
    end_ = 0;
    congested_ = false;
}

void Outbox::drop(Index i, SendCause cause) noexcept {
    report_dropped(view(i), cause);
    ++(counters_.*cause);
    if (in_flight_) in_flight_->dropped(view(i));
    leave_bucket(i);
    queues_[entries_[i].traffic].remove(i);
    update_waiting_class(entries_[i].traffic);
    release(i);
}

Outbox::Schedule Outbox::plan(ano::TimePoint now) noexcept {
    Schedule plan{{}, {}, shares_};
    plan.next.fill(none);
    for (std::size_t t = 0; t < traffic_classes; ++t) {
        if (queues_[t].empty()) continue;
        queues_[t].start_plan();
        look_at(plan, t, now);
    }
    return plan;
}

// The next frame of the class that is not stale.
void Outbox::look_at(Schedule& plan, std::size_t traffic, ano::TimePoint now) noexcept {
    Index i = queues_[traffic].next_planned();
    for (; i != none && entries_[i].stale_at <= now.time_since_epoch(); i = queues_[traffic].next_planned())
        drop(i, &SendCounters::stale);
    plan.next[traffic] = i;
    plan.sizes[traffic] = i != none ? entries_[i].size : 0;
}

Outbox::Index Outbox::pop_first_frame() noexcept {
    if (FairQueue* queue = in_order()) {
        const Index i = queue->front();
        shares_.leaves_alone(entries_[i].traffic, entries_[i].size);
        leave_bucket(i);
        queue->pop_front();
        update_waiting_class(entries_[i].traffic);
        return i;
    }
    ClassShares::Sizes sizes{};
    std::array<Index, traffic_classes> next{};
    for (std::size_t t = 0; t < traffic_classes; ++t) {
        if (queues_[t].empty()) continue;
        next[t] = queues_[t].next();
        sizes[t] = entries_[next[t]].size;
    }
    const std::size_t traffic = shares_.choose(sizes);
    const Index i = next[traffic];
    shares_.leaves(traffic, sizes);
    leave_bucket(i);
    queues_[traffic].pop();
    update_waiting_class(traffic);
    return i;
}

}    // namespace anogate
