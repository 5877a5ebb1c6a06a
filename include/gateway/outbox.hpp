// What waits to leave by one channel: bounded, whole frames only, every drop counted by cause.
//
// Flow:    outbox.push(frame)                                   // from the router
//          outbox.gather(pieces)                                // when the wire can take something
//          outbox.sent(bytes), or outbox.sent_frame() / outbox.drop_frame(cause) for datagrams
#pragma once
#include <ano/frame.hpp>
#include <gateway/counters.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace anogate {

/// First in, first out. A full outbox drops its oldest, but never a frame of which a part has left already. Neither throws
/// nor allocates after construction; constant time a frame, amortised.
class Outbox {
public:
    struct Options {
        std::size_t bytes = 32 * 1024;    // bound of what waits; at least overhead + max_data
        std::size_t max_data = 4096;      // frames with more DATA are counted too_big
    };
    explicit Outbox(const Options& options);

    /// A frame to leave; its bytes are copied. While closed, it is counted link_down.
    void push(ano::FrameView frame) noexcept;

    /// What leaves next, in order, one piece a frame; the first piece is the rest of a frame when a part of it has left.
    /// Returns how many pieces were filled in; they stay valid until the next call of another member.
    std::size_t gather(std::span<std::span<const std::uint8_t>> pieces) const noexcept;
    /// A stream took `bytes` of what gather() gave.
    void sent(std::size_t bytes) noexcept;
    /// A datagram took the first frame of what gather() gave.
    void sent_frame() noexcept;
    /// The first frame of what gather() gave can't be sent, for `cause`. Not for one that has begun to leave.
    void drop_frame(std::uint64_t SendCounters::*cause) noexcept;

    /// The wire is there. An outbox starts closed.
    void open() noexcept { open_ = true; }
    /// The wire is gone: what waits is counted link_down.
    void close() noexcept;

    bool is_open() const noexcept { return open_; }
    bool empty() const noexcept { return frames_ == 0; }
    std::size_t waiting() const noexcept { return frames_; }
    std::size_t waiting_bytes() const noexcept { return bytes_; }
    const SendCounters& counters() const noexcept { return counters_; }

private:
    // A frame is Entry and bytes side by side: frames stand in `arena_` in their order, between `begin_` and `end_`.
    struct Entry {
        std::uint32_t at;
        std::uint32_t size;
    };
    Entry& front() noexcept { return entries_[first_]; }
    void remove_front() noexcept;
    void drop_oldest() noexcept;
    void make_room(std::size_t size) noexcept;
    void compact() noexcept;

    Options options_;
    std::size_t capacity_;       // of the arena: twice the bound, so that compacting is rare
    std::size_t most_entries_;
    std::unique_ptr<std::uint8_t[]> arena_;
    std::unique_ptr<Entry[]> entries_;
    std::size_t first_ = 0;      // entries_[first_, last_) wait
    std::size_t last_ = 0;
    std::size_t end_ = 0;        // where the next frame's bytes go
    std::size_t frames_ = 0;
    std::size_t bytes_ = 0;
    std::size_t partly_sent_ = 0;    // bytes of the first frame that have left
    bool open_ = false;
    SendCounters counters_;
};

}  // namespace anogate
