// The datagrams of one peer that were read and are waiting for their turn.
#pragma once
#include <ano/lazy_array.hpp>
#include <ano/time.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace anogate {

/// First in, first out; when the queue is full, the oldest datagrams are dropped. No allocation after construction.
class DatagramQueue {
public:
    struct Datagram {
        std::span<const std::uint8_t> bytes;
        ano::TimePoint arrived_at;
    };
    static constexpr std::size_t max_bytes = 68 * 1024;    // waiting, with a Head each: more than the largest datagram

    /// Copies the datagram, which has at most 65,535 bytes. Returns the number of older ones dropped to make room for it.
    std::size_t push(std::span<const std::uint8_t> bytes, ano::TimePoint arrived_at) noexcept {
        const std::size_t needed = sizeof(Head) + bytes.size();
        std::size_t dropped = 0;
        for (; end_ - begin_ + needed > max_bytes; ++dropped) pop();
        if (end_ + needed > capacity) compact();
        const Head head{arrived_at.time_since_epoch(), bytes.size()};
        std::memcpy(room_.get() + end_, &head, sizeof head);
        if (!bytes.empty()) std::memcpy(room_.get() + end_ + sizeof head, bytes.data(), bytes.size());
        end_ += needed;
        ++count_;
        return dropped;
    }
    /// Removes the oldest datagram; the queue must not be empty. The bytes stay valid until the next push().
    Datagram pop() noexcept {
        Head head;
        std::memcpy(&head, room_.get() + begin_, sizeof head);
        const Datagram first{{room_.get() + begin_ + sizeof head, head.size}, ano::TimePoint{head.arrived_at}};
        begin_ += sizeof head + head.size;
        if (--count_ == 0) begin_ = end_ = 0;
        return first;
    }
    bool empty() const noexcept { return count_ == 0; }
    std::size_t count() const noexcept { return count_; }

private:
    struct Head {
        ano::Duration arrived_at{};
        std::size_t size = 0;
    };
    static constexpr std::size_t capacity = 2 * max_bytes;    // twice, so that compacting is rare

    void compact() noexcept {
        std::memmove(room_.get(), room_.get() + begin_, end_ - begin_);
        end_ -= begin_;
        begin_ = 0;
    }

    ano::LazyArray<std::uint8_t> room_{capacity};
    std::size_t begin_ = 0, end_ = 0;
    std::size_t count_ = 0;
};

}    // namespace anogate
