#include <gateway/question_queue.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

namespace anogate {

namespace {

constexpr std::int32_t one_by_one = ano::overhead;    // bytes of a turn: less than a question, so that each sends one

std::size_t max_frames(const QuestionQueue::Options& options) noexcept { return options.bytes / ano::overhead + 1; }

}    // namespace

QuestionQueue::QuestionQueue(Outbox& outbox, const Options& options)
    : outbox_{outbox},
      options_{options},
      room_{2 * options.bytes},
      frames_{max_frames(options)},
      turns_{frames_.get(), max_frames(options), one_by_one} {
    outbox_.set_in_flight(&in_flight_);
}

SendCause QuestionQueue::push(ano::FrameView frame, QueuePolicy policy, ano::TimePoint now, ChannelId from,
                              ano::TimePoint arrived_at) noexcept {
    if (!outbox_.is_open() || !question_in(frame)) return outbox_.push(frame, policy, arrived_at, from);
    release(now);    // waiting questions go first
    if (in_flight_.has_place(from)) {
        served_[index(from)] = ++handed_over_;
        return outbox_.push(frame, policy, arrived_at, from);
    }
    const SendCause cause = store(frame, arrived_at, from);
    if (!cause) release(now);    // it may get a place of another sender
    return cause;
}

void QuestionQueue::grow_older(ano::Duration time) noexcept {
    for (FrameIndex i = in_room_.first; i != no_frame; i = frames_[i].in_arena.behind) frames_[i].stale_at -= time;
}

bool QuestionQueue::receive(ano::FrameView frame, ano::TimePoint now) noexcept {
    return in_flight_.receive(frame) && release(now);
}

bool QuestionQueue::release(ano::TimePoint now) noexcept {
    bool released = false;
    in_flight_.expire(now);
    while (!turns_.empty()) {
        if (now >= stale_at(oldest())) {
            drop(oldest(), &SendCounters::stale);
        } else if (const auto next = next_sender()) {
            send_restart_state(turns_.first_of(*next, 0), *next);
            released = true;
        } else if (!has_sender_without_question() || !in_flight_.expire_one(now)) {
            break;
        }
    }
    return released;
}

// The gateway itself, if it has no place. Else the sender with the fewest places, and among equals the one served longest ago.
std::optional<ChannelId> QuestionQueue::next_sender() const noexcept {
    if (is_waiting(ourselves) && in_flight_.places(ourselves) == 0 && in_flight_.has_place(ourselves)) return ourselves;
    std::optional<ChannelId> best;
    const auto rank = [this](ChannelId from) { return std::pair{in_flight_.places(from), served_[index(from)]}; };
    for (std::size_t c = 0; c < senders; ++c) {
        const auto from = static_cast<ChannelId>(c);
        if (is_waiting(from) && in_flight_.has_place(from) && (!best || rank(from) < rank(*best))) best = from;
    }
    return best;
}

bool QuestionQueue::has_sender_without_question() const noexcept {
    for (std::size_t c = 0; c < senders; ++c)
        if (is_waiting(static_cast<ChannelId>(c)) && in_flight_.places(static_cast<ChannelId>(c)) == 0) return true;
    return false;
}

// Questions that wait in the outbox may be dropped there without notice, so check again after some time.
std::optional<ano::TimePoint> QuestionQueue::next_look(ano::TimePoint now) const noexcept {
    if (turns_.empty()) return std::nullopt;
    ano::TimePoint room_at = in_flight_.next_expiry().value_or(now + InFlight::patience);
    if (const auto early = in_flight_.next_early(); early && has_sender_without_question()) room_at = std::min(room_at, *early);
    return std::min(room_at, stale_at(oldest()));
}

bool QuestionQueue::has_waiting(ChannelId from) const noexcept {
    for (FrameIndex i = in_room_.first; i != no_frame; i = frames_[i].in_arena.behind)
        if (turns_.channel_of(i) == from) return true;
    return false;
}

void QuestionQueue::drop_waiting(SendCause cause) noexcept {
    while (!turns_.empty()) drop(oldest(), cause);
}

void QuestionQueue::close() noexcept {
    drop_waiting(&SendCounters::link_down);
    in_flight_.clear();
}

SendCause QuestionQueue::store(ano::FrameView frame, ano::TimePoint arrived_at, ChannelId from) noexcept {
    ++counters_.offered;
    const auto bytes = frame.bytes();
    if (bytes.size() > options_.bytes) {
        ++counters_.queue_full;
        return &SendCounters::queue_full;
    }
    while (turns_.bytes() + bytes.size() > options_.bytes) drop(turns_.next_evicted(), &SendCounters::queue_full);
    if (end_ + bytes.size() > 2 * options_.bytes) compact();
    const FrameIndex i = free_ != no_frame ? free_ : used_++;
    WaitingFrame& entry = frames_[i];
    if (i == free_) free_ = entry.in_flow.behind;
    entry = {};
    entry.at = static_cast<std::uint32_t>(end_);
    entry.size = static_cast<std::uint32_t>(bytes.size()) & 0xFFFFFFFu;
    entry.stale_at = (arrived_at + options_.age).time_since_epoch();
    std::memcpy(room_.get() + end_, bytes.data(), bytes.size());
    end_ += bytes.size();
    append<&WaitingFrame::in_arena>(frames_.get(), in_room_, i);
    turns_.push(i, from, 0);    // all askers of a channel count as one sender
    return nullptr;
}

void QuestionQueue::send_restart_state(FrameIndex i, ChannelId from) noexcept {
    const ano::FrameView frame{{room_.get() + frames_[i].at, frames_[i].size}};
    --counters_.offered;    // from now on, the outbox counts the question
    const SendCause cause = outbox_.push(frame, policy_of(frame.id()), stale_at(i) - options_.age, from);
    if (cause) outbox_.report_dropped(frame, cause);
    served_[index(from)] = ++handed_over_;
    turns_.remove(i);
    forget(i);
}

void QuestionQueue::drop(FrameIndex i, SendCause cause) noexcept {
    ++(counters_.*cause);
    outbox_.report_dropped(ano::FrameView{{room_.get() + frames_[i].at, frames_[i].size}}, cause);
    turns_.remove(i);
    forget(i);
}

// Frees the entry of a question, which must have been removed from turns_.
void QuestionQueue::forget(FrameIndex i) noexcept {
    unlink<&WaitingFrame::in_arena>(frames_.get(), in_room_, i);
    frames_[i].in_flow.behind = free_;
    free_ = i;
    if (!turns_.empty()) return;
    free_ = no_frame;
    used_ = 0;
    end_ = 0;
}

void QuestionQueue::compact() noexcept {
    std::size_t to = 0;
    for (FrameIndex i = in_room_.first; i != no_frame; i = frames_[i].in_arena.behind) {
        std::memmove(room_.get() + to, room_.get() + frames_[i].at, frames_[i].size);
        frames_[i].at = static_cast<std::uint32_t>(to);
        to += frames_[i].size;
    }
    end_ = to;
}

}    // namespace anogate
