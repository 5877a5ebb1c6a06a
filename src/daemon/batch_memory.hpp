// The memory of batches of records that nobody needs any more, for the next ones.
#pragma once
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace anogate {

/// Batches come from one thread; whichever thread lets go of one last gives its memory back. Neither waits for the other: memory that
/// can't be given back at once is freed.
class BatchMemory {
public:
    static constexpr std::size_t max_kept = 2 * 1024 * 1024;    // bytes
    static constexpr std::size_t min_kept = 4096;               // of a batch: smaller ones are not worth it

    /// `size` bytes, of any content, in at most twice as much memory. Throws std::bad_alloc.
    std::shared_ptr<std::string> take(std::size_t size) {
        std::unique_ptr<std::string> batch = kept_->take(2 * size);
        if (!batch) batch = std::make_unique<std::string>();
        batch->resize(size);
        return {batch.release(), [kept = kept_](std::string* used) { kept->give(std::unique_ptr<std::string>{used}); }};
    }
    /// Frees what is kept, and what is in use when that is let go of.
    void clear() { kept_ = std::make_shared<Kept>(); }
    std::size_t bytes_kept() const { return kept_->bytes(); }

private:
    class Kept {
    public:
        Kept() { batches_.reserve(max_kept / min_kept); }

        /// nullptr: there is none, or the next one has a capacity above `max_capacity`.
        std::unique_ptr<std::string> take(std::size_t max_capacity) noexcept {
            const std::unique_lock lock{mutex_, std::try_to_lock};
            if (!lock || batches_.empty() || batches_.back()->capacity() > max_capacity) return nullptr;
            std::unique_ptr<std::string> batch = std::move(batches_.back());
            batches_.pop_back();
            bytes_ -= batch->capacity();
            return batch;
        }
        void give(std::unique_ptr<std::string> batch) noexcept {
            if (batch->capacity() < min_kept) return;
            const std::unique_lock lock{mutex_, std::try_to_lock};
            if (!lock || bytes_ + batch->capacity() > max_kept) return;
            bytes_ += batch->capacity();
            batches_.push_back(std::move(batch));    // there is room for it
        }
        std::size_t bytes() const {
            const std::lock_guard lock{mutex_};
            return bytes_;
        }

    private:
        mutable std::mutex mutex_;
        std::vector<std::unique_ptr<std::string>> batches_;
        std::size_t bytes_ = 0;    // of these
    };

    std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();
};

}    // namespace anogate
