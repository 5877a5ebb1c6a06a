// A frame that waits in an outbox, and the lists that contain it, which use array indices instead of pointers.
#pragma once
#include <ano/time.hpp>

#include <cstdint>

namespace anogate {

using FrameIndex = std::uint32_t;
inline constexpr FrameIndex no_frame = UINT32_MAX;

struct Neighbours {
    FrameIndex before;
    FrameIndex behind;
};

struct WaitingFrame {
    Neighbours in_flow;
    Neighbours in_arena;
    Neighbours in_bucket;
    std::uint32_t at;      // offset of its bytes
    std::uint32_t key;     // a newer frame with the same key may replace it
    std::uint32_t flow;    // the node of its sender in FairQueue
    std::uint32_t size : 28;
    std::uint32_t traffic : 2;
    std::uint32_t replaceable : 1;    // it is in a bucket
    std::uint32_t overtakes : 1;      // it is sent before the other frames of its sender
    std::uint64_t number;             // in the order of push()
    std::uint64_t turn;               // the number of the oldest frame that it has replaced, else its own
    ano::Duration stale_at;           // since the clock's epoch
};
static_assert(sizeof(WaitingFrame) == 64);

struct FrameList {
    FrameIndex first;
    FrameIndex last;
};
inline constexpr FrameList no_frames{no_frame, no_frame};

template <Neighbours WaitingFrame::*in>
void append(WaitingFrame* frames, FrameList& list, FrameIndex i) noexcept {
    (frames[i].*in) = {list.last, no_frame};
    if (list.last == no_frame) list.first = i;
    else (frames[list.last].*in).behind = i;
    list.last = i;
}

template <Neighbours WaitingFrame::*in>
void unlink(WaitingFrame* frames, FrameList& list, FrameIndex i) noexcept {
    const Neighbours at = frames[i].*in;
    if (at.before == no_frame) list.first = at.behind;
    else (frames[at.before].*in).behind = at.behind;
    if (at.behind == no_frame) list.last = at.before;
    else (frames[at.behind].*in).before = at.before;
}

}    // namespace anogate
