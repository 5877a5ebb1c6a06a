#include <gateway/outbox.hpp>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace anogate {

Outbox::Outbox(const Options& options)
    : options_{options},
      capacity_{2 * options.bytes},
      most_entries_{2 * (options.bytes / ano::overhead + 1)},
      arena_{new std::uint8_t[capacity_]},
      entries_{new Entry[most_entries_]} {
    assert(options.bytes >= ano::overhead + options.max_data && options.bytes <= UINT32_MAX / 2);
}

void Outbox::push(ano::FrameView frame) noexcept {
    ++counters_.offered;
    const auto bytes = frame.bytes();
    if (!open_) {
        ++counters_.link_down;
        return;
    }
    if (bytes.size() > ano::overhead + options_.max_data) {
        ++counters_.too_big;
        return;
    }
    make_room(bytes.size());
    std::memcpy(arena_.get() + end_, bytes.data(), bytes.size());
    entries_[last_++] = {static_cast<std::uint32_t>(end_), static_cast<std::uint32_t>(bytes.size())};
    end_ += bytes.size();
    bytes_ += bytes.size();
    ++frames_;
}

std::size_t Outbox::gather(std::span<std::span<const std::uint8_t>> pieces) const noexcept {
    const std::size_t count = std::min(pieces.size(), frames_);
    for (std::size_t i = 0; i < count; ++i) {
        const Entry& entry = entries_[first_ + i];
        pieces[i] = {arena_.get() + entry.at, entry.size};
    }
    if (count > 0) pieces[0] = pieces[0].subspan(partly_sent_);
    return count;
}

void Outbox::sent(std::size_t bytes) noexcept {
    assert(bytes <= bytes_ - partly_sent_);
    while (bytes > 0 && frames_ > 0) {
        const std::size_t rest = front().size - partly_sent_;
        if (bytes < rest) {
            partly_sent_ += bytes;
            return;
        }
        bytes -= rest;
        sent_frame();
    }
}

void Outbox::sent_frame() noexcept {
    ++counters_.frames_out;
    counters_.bytes_out += front().size;
    if (front().size == ano::overhead) ++counters_.empty_out;
    remove_front();
}

void Outbox::drop_frame(std::uint64_t SendCounters::*cause) noexcept {
    assert(partly_sent_ == 0 || !open_);    // the receiver would take what follows for the rest of it
    ++(counters_.*cause);
    remove_front();
}

void Outbox::close() noexcept {
    open_ = false;
    while (frames_ > 0) drop_frame(&SendCounters::link_down);
}

void Outbox::remove_front() noexcept {
    assert(frames_ > 0);
    bytes_ -= front().size;
    partly_sent_ = 0;
    ++first_;
    if (--frames_ == 0) first_ = last_ = end_ = 0;
}

// The front itself when nothing of it has left, else the one behind it.
void Outbox::drop_oldest() noexcept {
    if (partly_sent_ > 0) {
        Entry& begun = entries_[first_];
        Entry& oldest = entries_[first_ + 1];
        bytes_ -= oldest.size;
        oldest = begun;
        ++first_;
        --frames_;
        ++counters_.queue_full;
    } else {
        drop_frame(&SendCounters::queue_full);
    }
}

// A frame that has begun to leave stands above the bound when nothing else is left to drop.
void Outbox::make_room(std::size_t size) noexcept {
    while (bytes_ + size > options_.bytes && frames_ > (partly_sent_ > 0 ? 1u : 0u)) drop_oldest();
    if (end_ + size > capacity_ || last_ == most_entries_) compact();
}

void Outbox::compact() noexcept {
    std::size_t to = 0;
    for (std::size_t i = 0; i < frames_; ++i) {
        const Entry entry = entries_[first_ + i];
        std::memmove(arena_.get() + to, arena_.get() + entry.at, entry.size);
        entries_[i] = {static_cast<std::uint32_t>(to), entry.size};
        to += entry.size;
    }
    first_ = 0;
    last_ = frames_;
    end_ = to;
}

}  // namespace anogate
