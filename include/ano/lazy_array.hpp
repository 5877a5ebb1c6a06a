// An array whose memory is large and mostly never accessed.
#pragma once
#include <cstddef>
#include <memory_resource>
#include <type_traits>
#include <utility>

namespace ano {

/// Uninitialised memory for `count` of T, from the default memory resource, which a program may set. Memory that is mapped only
/// for this costs only the pages that are accessed. Memory from the heap of the C library may consist of pages that were accessed
/// before.
template <class T>
class LazyArray {
    static_assert(std::is_trivially_default_constructible_v<T> &&
                  std::is_trivially_destructible_v<T>);    // otherwise construction or destruction would access all of it

public:
    explicit LazyArray(std::size_t count)
        : size_{count * sizeof(T)}, memory_{static_cast<T*>(from_->allocate(size_, alignof(T)))} {}
    LazyArray(LazyArray&& other) noexcept
        : from_{other.from_}, size_{other.size_}, memory_{std::exchange(other.memory_, nullptr)} {}
    LazyArray& operator=(LazyArray&& other) noexcept {
        std::swap(from_, other.from_);
        std::swap(size_, other.size_);
        std::swap(memory_, other.memory_);
        return *this;
    }
    ~LazyArray() {
        if (memory_) from_->deallocate(memory_, size_, alignof(T));
    }

    T* get() const noexcept { return memory_; }
    T& operator[](std::size_t i) const noexcept { return memory_[i]; }

private:
    std::pmr::memory_resource* from_ = std::pmr::get_default_resource();
    std::size_t size_;
    T* memory_;
};

}    // namespace ano
