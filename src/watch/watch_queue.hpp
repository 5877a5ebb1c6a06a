// The queue of a watcher of frames: waiting items, and counts of lost frames. No I/O.
//
// Flow:    queue.push(tables); queue.push(batch, now)    // as they arrive
//          while (auto item = queue.next(now)) ...       // in this order
#pragma once
#include <ano/time.hpp>
#include <record/decoding.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {

/// The names for the numbers in records; the index in a vector is the number.
struct WatchTables {
    std::vector<std::string> links;    // empty: unused number
    std::vector<std::string> peers;    // of the channels
    DecodingPtr decoding{};            // of the records
    std::string text;                  // {"links": [...], "channels": [...], "causes": [...], "decoding": {...}}
};

/// Counts of lost frames, by id.
struct LostFrames {
    std::array<std::uint32_t, 256> by_id{};
    std::uint64_t count = 0;
    std::chrono::milliseconds since{};    // the time since the first loss

    /// Adds the counts of `later`.
    void add(const LostFrames& later) noexcept {
        count += later.count;
        for (std::size_t id = 0; id < by_id.size(); ++id) by_id[id] += later.by_id[id];
    }
};

/// Bounded. After an item that does not fit, nothing more is accepted until all waiting items and then the loss are taken. Thus
/// the loss is reported before the next frame, and a slow watcher gets continuous sequences.
class WatchQueue {
public:
    /// Concatenated records; many queues may share one batch.
    using Batch = std::shared_ptr<const std::string>;
    using Tables = std::shared_ptr<const WatchTables>;
    using Item = std::variant<Batch, Tables, LostFrames>;

    explicit WatchQueue(std::size_t max_bytes) noexcept : max_bytes_{max_bytes} {}

    bool is_open() const noexcept { return lost_.count == 0; }
    /// False: it did not fit; the caller must count its frames with lose().
    bool push(Batch batch) {
        if (!is_open() || batch->size() > max_bytes_ - bytes_) return false;
        const std::size_t size = batch->size();
        items_.emplace_back(std::move(batch));
        bytes_ += size;
        return true;
    }
    /// Sets the names for all records pushed from now on.
    void push(Tables tables) {
        if (is_open()) items_.emplace_back(std::move(tables));
        else later_ = std::move(tables);
    }
    /// Counts a lost frame of this id.
    void lose(std::uint8_t id, ano::TimePoint now) noexcept {
        if (lost_.count++ == 0) since_ = now;
        ++lost_.by_id[id];
    }
    /// The next item; std::nullopt: the queue is empty.
    std::optional<Item> next(ano::TimePoint now) {
        if (!items_.empty()) {
            Item item = std::move(items_.front());
            items_.pop_front();
            if (const Batch* batch = std::get_if<Batch>(&item)) bytes_ -= (*batch)->size();
            return item;
        }
        if (is_open()) return std::nullopt;
        LostFrames lost = std::exchange(lost_, {});
        lost.since = std::chrono::duration_cast<std::chrono::milliseconds>(now - since_);
        if (later_) items_.emplace_back(std::exchange(later_, nullptr));
        return lost;
    }
    std::size_t bytes() const noexcept { return bytes_; }
    /// Number of lost frames that next() has not reported yet.
    std::uint64_t lost() const noexcept { return lost_.count; }

private:
    std::size_t max_bytes_;
    std::size_t bytes_ = 0;
    std::deque<Item> items_;
    Tables later_;    // pushed while the queue was closed
    LostFrames lost_;
    ano::TimePoint since_{};
};

}    // namespace anogate
