// The queue before the outbox of a device that accepts few questions at a time. Further questions wait here; all other traffic
// passes.
//
// Flow:    questions.push(frame, policy, now)    // every frame for the channel; then flush it
//          if (questions.hear(frame, now)) ...      // every frame from the channel; true: flush it
//          if (questions.release(now)) ...          // at next_look(); true: flush it
#pragma once
#include <ano/lazy_array.hpp>
#include <gateway/fair_queue.hpp>
#include <gateway/in_flight.hpp>
#include <gateway/outbox.hpp>
#include <gateway/waiting_frame.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// A sender is a channel on which questions are received; its questions are sent in the order of their arrival. The sender with
/// the fewest unanswered questions is next. Among equals it is the one that was served longest ago. While a waiting sender has no
/// place, another sender with several unanswered questions soon loses all but one (InFlight::early). One place is reserved for
/// the gateway itself. When the queue is full, the oldest question of the channel with the most waiting bytes is dropped. The
/// same age limit applies as in the outbox; drops here are counted here. Neither throws nor allocates after construction. The
/// time per question depends on the number of channels, and is amortised over its bytes.
class QuestionQueue {
public:
    struct Options {
        std::size_t bytes = 32 * 1024;                  // maximum of bytes waiting here
        ano::Duration age = std::chrono::seconds{5};    // questions that waited longer are dropped
    };
    /// `outbox` must not move while this is used; it reports the results of its frames here.
    QuestionQueue(Outbox& outbox, const Options& options);
    QuestionQueue(const QuestionQueue&) = delete;
    QuestionQueue& operator=(const QuestionQueue&) = delete;

    /// Passes a frame to the outbox. A question waits here while there is no place for its sender. Like Outbox::push(), it
    /// returns why the frame does not wait.
    SendCause push(ano::FrameView frame, QueuePolicy policy, ano::TimePoint now, ChannelId from = ourselves) noexcept {
        return push(frame, policy, now, from, now);
    }
    /// The same for a frame that arrived earlier.
    SendCause push(ano::FrameView frame, QueuePolicy policy, ano::TimePoint now, ChannelId from,
                   ano::TimePoint arrived_at) noexcept;
    /// A frame was received on the channel. True: it was an answer, and a waiting question was passed to the outbox.
    bool receive(ano::FrameView frame, ano::TimePoint now) noexcept;
    /// Passes the questions that may be sent to the outbox and drops stale ones. True: some were passed.
    bool release(ano::TimePoint now) noexcept;
    /// When to call release(); std::nullopt: nothing waits.
    std::optional<ano::TimePoint> next_look(ano::TimePoint now) const noexcept;
    /// As Outbox::grow_older(), for the questions that wait here.
    void grow_older(ano::Duration time) noexcept;
    /// Drops the waiting questions for `cause`.
    void drop_waiting(SendCause cause) noexcept;
    /// Drops the waiting questions and counts them as link_down. Does not close the outbox.
    void close() noexcept;

    std::size_t waiting() const noexcept { return turns_.count(); }
    /// Whether a question waits here that was received on the channel `from`.
    bool has_waiting(ChannelId from) const noexcept;
    std::size_t in_flight() const noexcept { return in_flight_.size(); }
    /// Counts the questions that wait or were dropped here; those passed to the outbox are counted there.
    const SendCounters& counters() const noexcept { return counters_; }

private:
    SendCause store(ano::FrameView frame, ano::TimePoint arrived_at, ChannelId from) noexcept;
    FrameIndex oldest() const noexcept { return in_room_.first; }
    ano::TimePoint stale_at(FrameIndex i) const noexcept { return ano::TimePoint{frames_[i].stale_at}; }
    std::optional<ChannelId> next_sender() const noexcept;
    bool has_sender_without_question() const noexcept;
    bool is_waiting(ChannelId from) const noexcept { return turns_.first_of(from, 0) != no_frame; }
    void send_restart_state(FrameIndex i, ChannelId from) noexcept;
    void drop(FrameIndex i, SendCause cause) noexcept;
    void forget(FrameIndex i) noexcept;
    void compact() noexcept;

    Outbox& outbox_;
    InFlight in_flight_;
    Options options_;
    ano::LazyArray<std::uint8_t> room_;    // twice Options::bytes, so that compacting is rare
    std::size_t end_ = 0;                  // where the bytes of the next question go
    ano::LazyArray<WaitingFrame> frames_;
    FrameIndex used_ = 0;              // frames_[0, used_) have been used since the queue was last empty
    FrameIndex free_ = no_frame;       // of those, the free ones
    FrameList in_room_ = no_frames;    // all questions, in the order of their arrival, which is that of their bytes
    FairQueue turns_;                  // the waiting questions of each sender, and the sender with the most
    static constexpr std::size_t senders = max_channels + 1;
    std::array<std::uint64_t, senders> served_{};    // the number of its last question that was passed on
    std::uint64_t handed_over_ = 0;
    SendCounters counters_;
};

}    // namespace anogate
