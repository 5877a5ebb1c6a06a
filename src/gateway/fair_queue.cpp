#include <gateway/fair_queue.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

// The maximum number of senders that are compared for the most waiting bytes: 250 forged addresses must not make push() slow.
constexpr int max_flows_searched = 16;

}    // namespace

FairQueue::FairQueue(WaitingFrame* frames, std::size_t max_frames, std::int32_t quantum)
    : frames_{frames}, nodes_{first_flow + std::min(max_frames, channels * 256)}, quantum_{quantum} {
    clear();
}

void FairQueue::clear() noexcept {
    nodes_[sole].now = {quantum_, 0, nobody, false, no_frames, no_frames};
    nodes_[sole].plan = 0;
    buckets_.fill(nobody);
    enrolled_.reset();
    used_ = first_flow;
    free_ = nobody;
    shared_ = false;
    count_ = bytes_ = 0;
}

FairQueue::Number FairQueue::flow_of_many(std::uint32_t key) noexcept {
    if (!shared_) {
        shared_ = true;
        nodes_[root] = {{0, 0, nobody, false, no_frames, no_frames}, {}, 0, {}, nobody, nobody, nobody, 0};
        nodes_[sole].now.balance = quantum_;
        nodes_[sole].now.bytes = static_cast<std::uint32_t>(bytes_);
        enrol(sole);
    }
    Number n = bucket(key);
    while (n != nobody && nodes_[n].key != key) n = nodes_[n].chained;
    return n != nobody ? n : new_flow(key);
}

FairQueue::Number FairQueue::new_flow(std::uint32_t key) noexcept {
    Number n = free_;
    if (n != nobody) free_ = nodes_[n].chained;
    else n = used_++;
    nodes_[n].now = {quantum_, 0, nobody, false, no_frames, no_frames};
    nodes_[n].plan = 0;
    nodes_[n].key = key;
    enrol(n);
    return n;
}

// A new flow gets its turn after the others of its channel, a new channel before all others. So a channel that sends rarely does
// not wait for those that always send.
void FairQueue::enrol(Number flow) noexcept {
    const std::uint32_t from = nodes_[flow].key >> 8;
    const Number channel = first_channel + from;
    if (!enrolled_[from]) {
        enrolled_.set(from);
        nodes_[channel] = {{quantum_, 0, nobody, false, no_frames, no_frames}, {}, 0, {}, nobody, nobody, nobody, 0};
        join(root, channel);
        nodes_[root].now.turn = channel;
    }
    join(channel, flow);
    nodes_[flow].chained = std::exchange(bucket(nodes_[flow].key), flow);
    nodes_[channel].now.bytes += nodes_[flow].now.bytes;
    nodes_[root].now.bytes += nodes_[flow].now.bytes;
}

void FairQueue::grow(Number flow, std::uint32_t size) noexcept {
    nodes_[root].now.bytes += size;
    for (Number n = flow; n != root; n = nodes_[n].parent) {
        nodes_[n].now.bytes += size;
        Number& longest = nodes_[nodes_[n].parent].longest;
        if (longest == nobody || nodes_[n].now.bytes > nodes_[longest].now.bytes) longest = n;
    }
}

void FairQueue::shrink(Number flow, std::uint32_t size) noexcept {
    for (Number n = flow; n != nobody; n = nodes_[n].parent) {
        nodes_[n].now.bytes -= size;
        if (nodes_[n].plan == plan_) nodes_[n].planned.bytes -= size;
    }
    if (nodes_[flow].now.bytes > 0) return;
    retire(flow);
    if (count_ > 0) return;
    enrolled_.reset();
    used_ = first_flow;
    free_ = nobody;
    shared_ = false;
}

template <bool planned>
void FairQueue::charge(Number flow, std::uint32_t size) noexcept {
    for (Number n = flow; n != root; n = nodes_[n].parent) {
        State& s = state<planned>(n);
        s.balance -= static_cast<std::int32_t>(size);
        if constexpr (planned) s.bytes -= size;
    }
    if constexpr (planned) state<planned>(root).bytes -= size;
}
template void FairQueue::charge<false>(Number, std::uint32_t) noexcept;
template void FairQueue::charge<true>(Number, std::uint32_t) noexcept;

void FairQueue::retire(Number flow) noexcept {
    leave(flow);
    Number* in = &bucket(nodes_[flow].key);
    while (*in != flow) in = &nodes_[*in].chained;
    *in = nodes_[flow].chained;
    if (flow != sole) nodes_[flow].chained = std::exchange(free_, flow);
}

// Adds `n` with the last turn of the ring.
void FairQueue::join(Number ring, Number n) noexcept {
    nodes_[n].parent = ring;
    Number& turn = nodes_[ring].now.turn;
    if (turn == nobody) {
        nodes_[n].in_ring = {n, n};
        turn = n;
        return;
    }
    const Number last = nodes_[turn].in_ring.before;
    nodes_[n].in_ring = {last, turn};
    nodes_[last].in_ring.behind = nodes_[turn].in_ring.before = n;
}

void FairQueue::leave(Number n) noexcept {
    Node& ring = nodes_[nodes_[n].parent];
    const Neighbours at = nodes_[n].in_ring;
    const Number behind = at.behind != n ? at.behind : nobody;
    nodes_[at.before].in_ring.behind = at.behind;
    nodes_[at.behind].in_ring.before = at.before;
    if (ring.now.turn == n) ring.now.turn = behind;
    if (ring.plan == plan_ && ring.planned.turn == n) ring.planned.turn = behind;
    if (ring.longest == n) ring.longest = nobody;
}

template <bool planned>
FrameIndex FairQueue::next_of_many() noexcept {
    if (state<planned>(root).bytes == 0) return no_frame;
    return first(state<planned>(in_turn<planned>(in_turn<planned>(root))));
}
template FrameIndex FairQueue::next_of_many<false>() noexcept;
template FrameIndex FairQueue::next_of_many<true>() noexcept;

// A channel with nothing waiting keeps its place until its turn comes and its balance is not negative. Otherwise it would be new
// with every frame, and each frame would be sent first.
template <bool planned>
FairQueue::Number FairQueue::in_turn(Number ring) noexcept {
    for (;;) {
        State& at = state<planned>(ring);
        const Number n = at.turn;
        State& s = state<planned>(n);
        if (s.balance <= 0) {
            s.balance += quantum_;
        } else if (s.bytes > 0) {
            return n;
        } else if (!planned) {
            enrolled_.reset(n - first_channel);
            leave(n);
            continue;
        }
        at.turn = nodes_[n].in_ring.behind;
    }
}

FairQueue::Number FairQueue::longest(Number ring) noexcept {
    const Number start = nodes_[ring].now.turn;
    Number most = start;
    int looked = 0;
    for (Number n = nodes_[start].in_ring.behind; n != start && ++looked < max_flows_searched; n = nodes_[n].in_ring.behind)
        if (nodes_[n].now.bytes > nodes_[most].now.bytes) most = n;
    const Number before = nodes_[ring].longest;
    if (before != nobody && nodes_[before].now.bytes > nodes_[most].now.bytes) most = before;
    return nodes_[ring].longest = most;
}

FrameIndex FairQueue::next_evicted() noexcept {
    const State& flow = nodes_[shared_ ? longest(longest(root)) : sole].now;
    if (flow.overtaking.first == no_frame || flow.rest.first == no_frame)
        return flow.rest.first != no_frame ? flow.rest.first : flow.overtaking.first;
    return frames_[flow.rest.first].number < frames_[flow.overtaking.first].number ? flow.rest.first : flow.overtaking.first;
}

}    // namespace anogate
