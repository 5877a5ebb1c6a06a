// The frames that wait to be sent on one channel: bounded, whole frames only, every drop counted by cause.
//
// Flow:    outbox.push(frame, policy, arrived_at)       // from the router
//          outbox.gather(pieces, now, budget)              // when the wire accepts bytes
//          outbox.sent(bytes), or outbox.sent_frame() / outbox.drop_frame(cause) for datagrams
//          outbox.set_congested()                          // when the wire accepts no more and frames still wait
#pragma once
#include <ano/frame.hpp>
#include <ano/image_length.hpp>
#include <ano/lazy_array.hpp>
#include <ano/time.hpp>
#include <gateway/class_shares.hpp>
#include <gateway/counters.hpp>
#include <gateway/fair_queue.hpp>
#include <gateway/outbox_watch.hpp>
#include <gateway/queue_policy.hpp>
#include <gateway/waiting_frame.hpp>

#include <array>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace anogate {

class InFlight;

/// How long a line of `rate` bytes/s needs for the zero bytes of a flush; zero if the rate is not known (0).
constexpr ano::Duration time_of_flush(std::size_t bytes, std::uint32_t rate) noexcept {
    return rate > 0 ? ano::Duration{std::chrono::seconds{bytes}} / rate : ano::Duration{};
}

/// Urgent frames are sent first, then telemetry, then bulk, but each waiting class gets at least a tenth of the bytes. Within a
/// class, each channel on which frames are received has the same share, and within a channel each sender. Frames of one sender
/// are sent in the order of their arrival, except that sticks overtake. A partly sent frame is dropped only by close(). Neither
/// throws nor allocates after construction. Constant time per frame, amortised over its bytes.
class Outbox {
public:
    struct Options {
        std::size_t bytes = 32 * 1024;    // maximum of waiting bytes; at least overhead + max_data, at most 1 GiB
        std::size_t max_data = 4096;      // frames with more DATA are counted too_big; images may have more (image_length.hpp)
        AgeLimits age{};
        std::size_t flush_bytes = 0;    // zero bytes of a flush_parser(), at most max_flush; 0: none, the wire is no UART
    };
    static constexpr std::size_t usual_flush = 206;    // the maximum DATA of vendor devices, plus overhead
    static constexpr std::size_t max_flush = 306;      // the same for older devices
    static constexpr std::size_t zeros_at_once = 32;
    static constexpr ano::Duration between_flushes = std::chrono::seconds{1};

    explicit Outbox(const Options& options);

    /// Queues a frame that arrived on the channel `from`; its bytes are copied. While closed, it is counted link_down. If the
    /// queue is full, the oldest frame of the sender with the most waiting bytes is dropped. It is taken from the lowest class
    /// that has more than the reserve of each class: a tenth of the room, or one frame of up to a quarter. That may be the frame
    /// itself. nullptr: it waits; otherwise the counter for the reason why it does not.
    SendCause push(ano::FrameView frame, QueuePolicy policy, ano::TimePoint arrived_at, ChannelId from = ourselves) noexcept;
    /// The same for a frame of the lowest class that is never dropped as stale.
    SendCause push(ano::FrameView frame) noexcept { return store(frame, {}, ano::TimePoint::max(), ourselves); }
    /// Queues zero bytes, which are sent before the next frame and are not part of one. They complete a damaged frame in which
    /// the parser of a device waits; a parser that searches for a header skips them. Sending them ends when a second frame waits.
    /// Returns false and queues nothing while frames wait, within between_flushes of the last time, or without
    /// Options::flush_bytes.
    bool flush_parser(ano::TimePoint now) noexcept;
    /// The time until between_flushes no longer prevents flush_parser(); zero: now, or another reason prevents it.
    ano::Duration until_flush(ano::TimePoint now) const noexcept;
    /// The unsent zero bytes; a stream gets them by gather() and sent().
    std::size_t zeros() const noexcept { return zeros_; }
    /// Whether a frame waits that was received on the channel `from`.
    bool has_waiting(ChannelId from) const noexcept;
    /// Whether a frame of this age must not be sent any more.
    bool is_stale(QueuePolicy policy, ano::Duration age) const noexcept;
    /// The clock of all ages did not count `time` (the machine was suspended): adds it to the age of all waiting frames.
    void grow_older(ano::Duration time) noexcept;
    /// Counts a frame that was refused before it was queued, for `cause` (limited, denied_out, link_down), and returns the cause.
    SendCause refuse(SendCause cause) noexcept {
        ++counters_.offered;
        ++(counters_.*cause);
        return cause;
    }

    /// The frame to be sent next: its unsent bytes (0: none waits), and whether an urgent frame waits.
    struct Next {
        std::size_t size = 0;
        bool urgent = false;
        bool is_zeros = false;    // `size` zero bytes, of which any number may be sent
    };
    Next next(ano::TimePoint now) noexcept;
    /// The frames to be sent next, in order, one piece each. The first piece is the rest of a partly sent frame, if there is one.
    /// Drops frames that are stale at `now`. At most `budget` bytes; a frame of which nothing was sent is included whole or not
    /// at all. Returns the number of pieces filled in; they stay valid until the next call of another member.
    std::size_t gather(std::span<std::span<const std::uint8_t>> pieces, ano::TimePoint now = ano::TimePoint::min(),
                       std::size_t budget = SIZE_MAX) noexcept;
    /// A stream accepted the first `bytes` of the pieces of gather().
    void sent(std::size_t bytes) noexcept;
    /// The first frame of gather() was sent as a datagram.
    void sent_frame() noexcept;
    /// The first frame of gather() can't be sent, for `cause`. Must not be called for a partly sent frame.
    void drop_frame(SendCause cause) noexcept;
    /// Drops all waiting frames, for `cause`. The rest of a partly sent frame is still sent.
    void drop_waiting(SendCause cause) noexcept;
    /// The wire accepts no more for now. Until nothing waits, newer frames replace older ones of their kind. Setpoints that are
    /// already followed by a newer one are dropped.
    void set_congested() noexcept {
        if (!std::exchange(congested_, frames_ > 0) && congested_) supersede_setpoints();
    }

    /// The wire is connected. An outbox starts closed.
    void open() noexcept { open_ = true; }
    /// The wire is disconnected: all waiting frames are dropped and counted link_down.
    void close() noexcept;

    /// `in_flight` is called for each frame that is queued, sent or dropped, except by close(). It must outlive this.
    void set_in_flight(InFlight* in_flight) noexcept { in_flight_ = in_flight; }
    /// `watch` is called when a frame is sent or dropped, with `channel`; it must outlive this. nullptr: no call.
    void watch(OutboxWatch* watch, ChannelId channel) noexcept {
        watch_ = watch;
        watched_as_ = channel;
    }
    /// For a queue before this outbox: calls the watch for `frame`, which was dropped there.
    void report_dropped(ano::FrameView frame, SendCause cause) const noexcept {
        if (watch_) [[unlikely]]
            watch_->dropped(watched_as_, frame, cause);
    }

    void set_age_limits(const AgeLimits& age) noexcept { options_.age = age; }
    bool is_open() const noexcept { return open_; }
    /// Whether a frame is partly sent: nothing else may be written before its rest.
    bool has_begun() const noexcept { return partly_sent_ > 0; }
    bool congested() const noexcept { return congested_; }
    /// Neither frames nor zero bytes wait.
    bool empty() const noexcept { return frames_ == 0 && zeros_ == 0; }
    std::size_t waiting() const noexcept { return frames_; }
    std::size_t waiting_bytes() const noexcept { return bytes_; }
    const SendCounters& counters() const noexcept { return counters_; }

private:
    using Index = FrameIndex;
    static constexpr Index none = no_frame;
    static constexpr std::size_t bucket_count = 256;

    // The next frame of each class, and the bytes sent by the classes.
    struct Schedule {
        std::array<Index, traffic_classes> next;
        ClassShares::Sizes sizes;
        ClassShares shares;
    };

    SendCause store(ano::FrameView frame, QueuePolicy policy, ano::TimePoint stale_at, ChannelId from) noexcept;
    std::uint64_t supersede(std::uint32_t key, ChannelId from) noexcept;
    void supersede_setpoints() noexcept;
    bool make_room(std::size_t size, TrafficClass traffic) noexcept;
    std::size_t next_evicted(std::size_t own, bool entitled) const noexcept;
    bool entitled(const FairQueue& queue, std::size_t more) const noexcept;
    bool has_more(const FairQueue& queue) const noexcept;
    void compact() noexcept;
    Index new_entry() noexcept;
    void leave_bucket(Index i) noexcept;
    void release(Index i) noexcept;
    void drop(Index i, SendCause cause) noexcept;
    // The only non-empty queue, if its frames are sent in the order of their arrival, else nullptr. Then no choice between frames
    // is necessary; this is usual when the line is fast enough.
    FairQueue* in_order() noexcept {
        const bool one_class = waiting_classes_ != 0 && (waiting_classes_ & (waiting_classes_ - 1)) == 0;
        FairQueue* const queue = one_class ? &queues_[static_cast<std::size_t>(std::countr_zero(waiting_classes_))] : nullptr;
        return queue && queue->in_order() ? queue : nullptr;
    }
    void update_waiting_class(std::size_t traffic) noexcept {
        if (queues_[traffic].empty()) waiting_classes_ &= ~(1u << traffic);
    }
    Schedule plan(ano::TimePoint now) noexcept;
    void look_at(Schedule& plan, std::size_t traffic, ano::TimePoint now) noexcept;
    Index pop_first_frame() noexcept;
    ano::FrameView view(Index i) const noexcept { return ano::FrameView{{arena_.get() + entries_[i].at, entries_[i].size}}; }
    FrameList& bucket(std::uint32_t key, ChannelId from) noexcept {
        return buckets_[(key ^ static_cast<std::uint32_t>(from) * 0x85EBCA6Bu) * 0x9E3779B1u >> 24];
    }

    Options options_;
    std::size_t capacity_;    // of the arena: twice Options::bytes, so that compacting is rare
    ano::LazyArray<std::uint8_t> arena_;
    ano::LazyArray<WaitingFrame> entries_;
    Index used_ = 0;         // entries_[0, used_) have been used since the outbox was last empty
    Index free_ = none;      // of those, the free ones
    std::size_t end_ = 0;    // where the next frame's bytes go

    std::array<FairQueue, traffic_classes> queues_;
    std::uint32_t waiting_classes_ = 0;    // one bit per class
    ClassShares shares_;
    FrameList in_arena_ = no_frames;                 // every frame, in the order of its bytes
    std::array<FrameList, bucket_count> buckets_;    // frames that may be replaced, by hash, oldest first

    Index begun_ = none;             // the partly sent frame; it is not in a queue
    std::size_t partly_sent_ = 0;    // how many of its bytes were sent
    std::size_t frames_ = 0;
    std::size_t bytes_ = 0;
    std::size_t zeros_ = 0;
    std::uint64_t zeros_before_ = 0;    // the number of the frame before which they are sent
    ano::TimePoint flush_again_at_ = ano::TimePoint::min();
    std::uint64_t pushed_ = 0;
    bool open_ = false;
    bool congested_ = false;
    InFlight* in_flight_ = nullptr;    // nullptr: no call
    OutboxWatch* watch_ = nullptr;     // the same
    ChannelId watched_as_{};
    ano::TimePoint gathered_at_{};    // the time of the last gather(), which counts as the time of sending
    SendCounters counters_;
};

}    // namespace anogate
