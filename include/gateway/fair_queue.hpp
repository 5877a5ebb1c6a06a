// The frames of one class, with a fair share for each sender: deficit round robin by the channel on which a frame was received,
// and within a channel by S_ADDR. A peer that forges 250 addresses gets the share of one peer, and several hosts that all have
// the address 0xFE get one share each.
//
// Flow:    queue.push(i, from, source)
//          queue.start_plan(); queue.next_planned(), queue.pop_planned() …    // which frames will be sent, in order
//          queue.next(), queue.take() …                                        // they are sent, in the same order
#pragma once
#include <ano/lazy_array.hpp>
#include <gateway/ids.hpp>
#include <gateway/waiting_frame.hpp>

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

namespace anogate {

/// Frames of one sender are sent in order, with one exception: frames with `overtakes` set alternate with the others and go
/// first. A channel that had no waiting frame lately sends first. Neither throws nor allocates after construction. Constant time
/// per frame, amortised over its bytes.
class FairQueue {
public:
    /// `frames`, of which at most `max_frames` wait here, must outlive this. When several senders wait, each sends `quantum`
    /// bytes (above 0) in its turn, plus the rest of a frame that begins within them.
    FairQueue(WaitingFrame* frames, std::size_t max_frames, std::int32_t quantum);

    /// `size` and `overtakes` of the frame must be set.
    void push(FrameIndex i, ChannelId from, std::uint8_t source) noexcept {
        const Number f = flow_of(static_cast<std::uint32_t>(index(from) << 8 | source));
        frames_[i].flow = f;
        Node& flow = nodes_[f];
        append<&WaitingFrame::in_flow>(frames_, line(flow.now, frames_[i].overtakes), i);
        bytes_ += frames_[i].size;
        ++count_;
        if (shared_) grow(f, frames_[i].size);
    }
    /// Removes any frame; while a plan is being made, only next_planned().
    void remove(FrameIndex i) noexcept {
        const WaitingFrame& frame = frames_[i];
        Node& flow = nodes_[frame.flow];
        if (flow.plan == plan_) skip(flow.planned, i);
        unlink<&WaitingFrame::in_flow>(frames_, line(flow.now, frame.overtakes), i);
        bytes_ -= frame.size;
        --count_;
        if (shared_) shrink(frame.flow, frame.size);
    }
    /// The frame to send next; no_frame: none waits.
    FrameIndex next() noexcept { return shared_ ? next_of_many<false>() : first(nodes_[sole].now); }
    /// Removes next() and charges it to the turn of its sender.
    void pop() noexcept {
        const FrameIndex i = next();
        pay<false>(i);
        remove(i);
    }

    /// Whether frames are sent in the order of push(), because there is one sender and no frame overtakes. Then pop_front() does
    /// the same as take(), and the frames after front() follow by `in_flow`.
    bool in_order() const noexcept { return !shared_ && nodes_[sole].now.overtaking.first == no_frame; }
    FrameIndex front() const noexcept { return nodes_[sole].now.rest.first; }
    void pop_front() noexcept {
        State& flow = nodes_[sole].now;
        const FrameIndex i = flow.rest.first;
        flow.overtook = false;
        --count_;
        bytes_ -= frames_[i].size;
        flow.rest.first = frames_[i].in_flow.behind;
        (flow.rest.first != no_frame ? frames_[flow.rest.first].in_flow.before : flow.rest.last) = no_frame;
    }

    /// The plan begins with all waiting frames. It is valid until the next push(), take() or remove() of a planned frame.
    void start_plan() noexcept { ++plan_; }
    FrameIndex next_planned() noexcept { return shared_ ? next_of_many<true>() : first(state<true>(sole)); }
    void pop_planned() noexcept {
        const FrameIndex i = next_planned();
        pay<true>(i);
        skip(nodes_[frames_[i].flow].planned, i);
    }

    /// The frame of one sender that is sent next; no_frame: none waits.
    FrameIndex first_of(ChannelId from, std::uint8_t source) const noexcept {
        const auto key = static_cast<std::uint32_t>(index(from) << 8 | source);
        if (!shared_) return count_ > 0 && nodes_[sole].key == key ? first(nodes_[sole].now) : no_frame;
        Number n = buckets_[bucket_of(key)];
        while (n != nobody && nodes_[n].key != key) n = nodes_[n].chained;
        return n != nobody ? first(nodes_[n].now) : no_frame;
    }
    /// The oldest frame of the sender with the most waiting bytes, on the channel with the most. The queue must not be empty.
    /// With many channels or senders, only some of them are compared.
    FrameIndex next_evicted() noexcept;
    /// The channel on which a waiting frame was received.
    ChannelId channel_of(FrameIndex i) const noexcept { return static_cast<ChannelId>(nodes_[frames_[i].flow].key >> 8); }
    /// The list that contains `i`: of its sender, the frames that overtake, or the others.
    const FrameList& line_of(FrameIndex i) const noexcept {
        const Node& flow = nodes_[frames_[i].flow];
        return frames_[i].overtakes ? flow.now.overtaking : flow.now.rest;
    }

    bool empty() const noexcept { return count_ == 0; }
    std::size_t count() const noexcept { return count_; }
    std::size_t bytes() const noexcept { return bytes_; }
    void clear() noexcept;

private:
    // Turns are kept in a tree: the root, below it channels, below them the flows of their senders. While only one
    // sender waits, only its flow is used, which is `sole`.
    using Number = std::uint32_t;
    static constexpr Number nobody = UINT32_MAX;
    static constexpr Number root = 0;
    static constexpr Number sole = 1;
    static constexpr Number first_channel = 2;
    static constexpr std::size_t channels = max_channels + 1;    // one more for the gateway itself
    static constexpr Number first_flow = first_channel + channels;
    static constexpr std::size_t bucket_count = 256;

    // The state that sending changes, stored twice: as it is now, and as it will be after the plan.
    struct State {
        std::int32_t balance;    // bytes it may still send in this turn
        std::uint32_t bytes;     // waiting
        Number turn;             // for a channel or the root: the child whose turn it is
        bool overtook;           // the last sent frame overtook others of this sender
        FrameList overtaking, rest;
    };
    struct Node {
        State now;
        State planned;    // valid when `plan` is that of the queue
        std::uint64_t plan;
        Neighbours in_ring;    // neighbours in a ring, in the order of turns
        Number parent;
        Number chained;       // flows: the next in its bucket, or the next free one
        Number longest;       // for a channel or the root: the child that had the most bytes when last compared
        std::uint32_t key;    // flows: channel and address
    };

    static FrameList& line(State& flow, bool overtakes) noexcept { return overtakes ? flow.overtaking : flow.rest; }
    static FrameIndex first(const State& flow) noexcept {
        const bool other = flow.overtaking.first == no_frame || (flow.overtook && flow.rest.first != no_frame);
        return other ? flow.rest.first : flow.overtaking.first;
    }
    // Removes a frame from its list, if it is the first there.
    void skip(State& flow, FrameIndex i) noexcept {
        FrameList& in = line(flow, frames_[i].overtakes);
        if (in.first == i) in.first = frames_[i].in_flow.behind;
    }
    template <bool planned>
    void pay(FrameIndex i) noexcept {
        State& flow = state<planned>(frames_[i].flow);
        flow.overtook = frames_[i].overtakes && flow.rest.first != no_frame;
        if (shared_) charge<planned>(frames_[i].flow, frames_[i].size);
    }
    template <bool planned>
    State& state(Number n) noexcept {
        if constexpr (!planned) return nodes_[n].now;
        if (nodes_[n].plan != plan_) {
            nodes_[n].planned = nodes_[n].now;
            nodes_[n].plan = plan_;
        }
        return nodes_[n].planned;
    }
    Number flow_of(std::uint32_t key) noexcept {
        if (count_ == 0) {
            nodes_[sole].key = key;
            nodes_[sole].now.overtook = false;
        }
        return !shared_ && nodes_[sole].key == key ? sole : flow_of_many(key);
    }
    // The hash puts the flows of one channel into different buckets.
    static std::size_t bucket_of(std::uint32_t key) noexcept { return (key ^ (key >> 8) * 0x9Du) % bucket_count; }
    Number& bucket(std::uint32_t key) noexcept { return buckets_[bucket_of(key)]; }

    Number flow_of_many(std::uint32_t key) noexcept;
    Number new_flow(std::uint32_t key) noexcept;
    void enrol(Number flow) noexcept;
    void grow(Number flow, std::uint32_t size) noexcept;
    void shrink(Number flow, std::uint32_t size) noexcept;
    template <bool planned>
    void charge(Number flow, std::uint32_t size) noexcept;
    void retire(Number flow) noexcept;
    void join(Number ring, Number n) noexcept;
    void leave(Number n) noexcept;
    Number longest(Number ring) noexcept;
    template <bool planned>
    FrameIndex next_of_many() noexcept;
    template <bool planned>
    Number in_turn(Number ring) noexcept;

    WaitingFrame* frames_;
    ano::LazyArray<Node> nodes_;
    std::int32_t quantum_;
    Number used_ = first_flow;    // nodes_[first_flow, used_) have been used as flows
    Number free_ = nobody;        // of those, the free ones
    bool shared_ = false;         // more than one sender has waited since the queue was last empty
    std::size_t count_ = 0;
    std::size_t bytes_ = 0;
    std::uint64_t plan_ = 1;            // nodes get the number of a plan when they are first used in it
    std::bitset<channels> enrolled_;    // channels that have a turn
    std::array<Number, bucket_count> buckets_;
};

}    // namespace anogate
