// Comes before the outbox of a device that takes few questions at a time: further questions wait here, and all other
// traffic passes.
//
// Flow:    questions.push(frame, policy, now)    // every frame for the channel; then flush it
//          if (questions.hear(frame, now)) ...      // every frame from the channel; true: flush it
//          if (questions.release(now)) ...          // at next_look(); true: flush it
#pragma once
#include <ano/room.hpp>
#include <gateway/fair_queue.hpp>
#include <gateway/in_flight.hpp>
#include <gateway/outbox.hpp>
#include <gateway/waiting_frame.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// The sender with the fewest unanswered questions is next, and of those the one that was so longest ago; a sender is the channel by
/// which questions came, and they leave in the order in which they came. While a sender waits that has no place, the unanswered
/// questions of another hold no more than one for long (InFlight::early). One place is kept for the gateway itself.
/// When full, the oldest question of the channel with the most bytes waiting is dropped. Their age counts as in the outbox; drops
/// here are counted here. Neither throws nor allocates after construction; a time for each question that depends on the number of
/// channels, and is amortised over its bytes.
class QuestionQueue {
public:
    struct Options {
        std::size_t bytes = 32 * 1024;                  // maximum that waits here
        ano::Duration age = std::chrono::seconds{5};    // questions that waited longer are dropped
    };
    /// `outbox` must not move while this is used; it reports to this what happens to its frames.
    QuestionQueue(Outbox& outbox, const Options& options);
    QuestionQueue(const QuestionQueue&) = delete;
    QuestionQueue& operator=(const QuestionQueue&) = delete;

    /// Passes a frame to the outbox; a question waits here while its sender can have no place. Like Outbox::push(), it returns
    /// why the frame does not wait.
    SendCause push(ano::FrameView frame, QueuePolicy policy, ano::TimePoint now, ChannelId from = ourselves) noexcept {
        return push(frame, policy, now, from, now);
    }
    /// The same for a frame that arrived earlier.
    SendCause push(ano::FrameView frame, QueuePolicy policy, ano::TimePoint now, ChannelId from,
                   ano::TimePoint arrived_at) noexcept;
    /// A frame came in by the channel. True: it was an answer, and a waiting question was passed to the outbox.
    bool hear(ano::FrameView frame, ano::TimePoint now) noexcept;
    /// Passes the questions that may be sent to the outbox and drops stale ones. True: some were passed.
    bool release(ano::TimePoint now) noexcept;
    /// When release() may have something to do; std::nullopt while nothing waits.
    std::optional<ano::TimePoint> next_look(ano::TimePoint now) const noexcept;
    /// As Outbox::grow_older(), for the questions that wait here.
    void grow_older(ano::Duration time) noexcept;
    /// Drops the waiting questions for `cause`.
    void drop_waiting(SendCause cause) noexcept;
    /// Drops the waiting questions and counts them as link_down. Does not close the outbox.
    void close() noexcept;

    std::size_t waiting() const noexcept { return turns_.count(); }
    /// Whether a question waits here that came by the channel `from`.
    bool has_waiting(ChannelId from) const noexcept;
    std::size_t in_flight() const noexcept { return in_flight_.size(); }
    /// Counts the questions that wait or were dropped here; those passed to the outbox are counted there.
    const SendCounters& counters() const noexcept { return counters_; }

private:
    SendCause store(ano::FrameView frame, ano::TimePoint arrived_at, ChannelId from) noexcept;
    FrameIndex oldest() const noexcept { return in_room_.first; }
    ano::TimePoint stale_at(FrameIndex i) const noexcept { return ano::TimePoint{frames_[i].stale_at}; }
    std::optional<ChannelId> next_sender() const noexcept;
    bool somebody_has_none() const noexcept;
    bool is_waiting(ChannelId from) const noexcept { return turns_.first_of(from, 0) != no_frame; }
    void hand_over(FrameIndex i, ChannelId from) noexcept;
    void drop(FrameIndex i, SendCause cause) noexcept;
    void forget(FrameIndex i) noexcept;
    void compact() noexcept;

    Outbox& outbox_;
    InFlight in_flight_;
    Options options_;
    ano::Room<std::uint8_t> room_;    // twice Options::bytes, so that compacting is rare
    std::size_t end_ = 0;             // where the bytes of the next question go
    ano::Room<WaitingFrame> frames_;
    FrameIndex used_ = 0;              // frames_[0, used_) have been used since nothing waited last
    FrameIndex free_ = no_frame;       // of those, the free ones
    FrameList in_room_ = no_frames;    // all questions, in the order in which they came, which is that of their bytes
    FairQueue turns_;                  // what waits of each sender, and who has the most
    static constexpr std::size_t senders = max_channels + 1;
    std::array<std::uint64_t, senders> served_{};    // the number of its last question that was handed over
    std::uint64_t handed_over_ = 0;
    SendCounters counters_;
};

}    // namespace anogate
