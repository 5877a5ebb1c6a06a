#include <gateway/question_queue.hpp>

#include <algorithm>
#include <cstring>

namespace anogate {

QuestionQueue::QuestionQueue(Outbox& outbox, const Options& options)
    : outbox_{outbox}, options_{options}, room_{new std::uint8_t[2 * options.bytes]} {
    outbox_.tell(&in_flight_);
}

void QuestionQueue::push(ano::FrameView frame, Treatment treatment, ano::TimePoint now, ChannelId from) noexcept {
    if (!outbox_.is_open() || !question_in(frame)) return outbox_.push(frame, treatment, now, from);
    release(now);    // what waits goes first
    if (in_flight_.has_room(now)) return outbox_.push(frame, treatment, now, from);
    store(frame, now, from);
}

bool QuestionQueue::hear(ano::FrameView frame, ano::TimePoint now) noexcept {
    return in_flight_.hear(frame) && release(now);
}

bool QuestionQueue::release(ano::TimePoint now) noexcept {
    bool released = false;
    while (frames_ > 0) {
        const Head head = first();
        if (now - head.arrived >= options_.age) {
            drop(&SendCounters::stale);
            continue;
        }
        if (!in_flight_.has_room(now)) break;
        const ano::FrameView frame{{room_.get() + begin_ + sizeof head, head.size}};
        --counters_.offered;    // the outbox counts it from here on
        outbox_.push(frame, treatment_of(frame.id()), head.arrived, head.from);
        pop();
        released = true;
    }
    return released;
}

// Those that wait in the outbox may be dropped there, which nobody tells: another look after a while.
std::optional<ano::TimePoint> QuestionQueue::next_look(ano::TimePoint now) const noexcept {
    if (frames_ == 0) return std::nullopt;
    const ano::TimePoint room_at = in_flight_.next_given_up().value_or(now + InFlight::patience);
    return std::min(room_at, first().arrived + options_.age);
}

void QuestionQueue::close() noexcept {
    while (frames_ > 0) drop(&SendCounters::link_down);
    in_flight_.clear();
}

QuestionQueue::Head QuestionQueue::first() const noexcept {
    Head head;
    std::memcpy(&head, room_.get() + begin_, sizeof head);
    return head;
}

void QuestionQueue::store(ano::FrameView frame, ano::TimePoint now, ChannelId from) noexcept {
    ++counters_.offered;
    const Head head{now, frame.bytes().size(), from};
    const std::size_t size = sizeof head + head.size;
    if (size > options_.bytes) return void(++counters_.queue_full);
    while (end_ - begin_ + size > options_.bytes) drop(&SendCounters::queue_full);
    if (end_ + size > 2 * options_.bytes) {
        std::memmove(room_.get(), room_.get() + begin_, end_ - begin_);
        end_ -= begin_;
        begin_ = 0;
    }
    std::memcpy(room_.get() + end_, &head, sizeof head);
    std::memcpy(room_.get() + end_ + sizeof head, frame.bytes().data(), head.size);
    end_ += size;
    ++frames_;
}

void QuestionQueue::pop() noexcept {
    begin_ += sizeof(Head) + first().size;
    if (--frames_ == 0) begin_ = end_ = 0;
}

void QuestionQueue::drop(std::uint64_t SendCounters::*cause) noexcept {
    ++(counters_.*cause);
    pop();
}

}    // namespace anogate
