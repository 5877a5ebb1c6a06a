// Reuses the memory of batches of records that are no longer in use.
#pragma once
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace anogate {

/// One thread takes batches; the thread that releases the last reference to a batch returns its memory. Neither thread waits for
/// the other: memory that can't be returned at once is freed.
class BatchMemory {
public:
    static constexpr std::size_t max_kept = 2 * 1024 * 1024;    // bytes
    static constexpr std::size_t min_kept = 4096;               // bytes of a batch; smaller ones are not kept

    /// `size` bytes of unspecified content; the capacity is at most twice that. Throws std::bad_alloc.
    std::shared_ptr<std::string> acquire(std::size_t size) {
        std::unique_ptr<std::string> batch = kept_->acquire(2 * size);
        if (!batch) batch = std::make_unique<std::string>();
        batch->resize(size);
        return {batch.release(), [kept = kept_](std::string* used) { kept->recycle(std::unique_ptr<std::string>{used}); }};
    }
    /// Frees the kept memory. Batches in use are freed, not kept, when they are released.
    void clear() { kept_ = std::make_shared<Kept>(); }
    std::size_t bytes_kept() const { return kept_->bytes(); }

private:
    class Kept {
    public:
        Kept() { batches_.reserve(max_kept / min_kept); }

        /// nullptr: none is kept, the next one has a capacity above `max_capacity`, or another thread holds the lock.
        std::unique_ptr<std::string> acquire(std::size_t max_capacity) noexcept {
            const std::unique_lock lock{mutex_, std::try_to_lock};
            if (!lock || batches_.empty() || batches_.back()->capacity() > max_capacity) return nullptr;
            std::unique_ptr<std::string> batch = std::move(batches_.back());
            batches_.pop_back();
            bytes_ -= batch->capacity();
            return batch;
        }
        void recycle(std::unique_ptr<std::string> batch) noexcept {
            if (batch->capacity() < min_kept) return;
            const std::unique_lock lock{mutex_, std::try_to_lock};
            if (!lock || bytes_ + batch->capacity() > max_kept) return;
            bytes_ += batch->capacity();
            batches_.push_back(std::move(batch));    // does not allocate: the capacity suffices
        }
        std::size_t bytes() const {
            const std::lock_guard lock{mutex_};
            return bytes_;
        }

    private:
        mutable std::mutex mutex_;
        std::vector<std::unique_ptr<std::string>> batches_;
        std::size_t bytes_ = 0;    // total capacity of batches_
    };

    std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();
};

}    // namespace anogate
