// Memory that is large and mostly never touched.
#pragma once
#include <cstddef>
#include <memory_resource>
#include <type_traits>
#include <utility>

namespace ano {

/// Room for `count` of T, uninitialised, from the default memory resource: a program says by it where rooms come from. Those that
/// the system gives cost the pages that are touched of them. A piece of the C library's heap costs what others have touched there.
template <class T>
class Room {
    static_assert(std::is_trivially_default_constructible_v<T> &&
                  std::is_trivially_destructible_v<T>);    // or all of it would be touched

public:
    explicit Room(std::size_t count) : size_{count * sizeof(T)}, memory_{static_cast<T*>(from_->allocate(size_, alignof(T)))} {}
    Room(Room&& other) noexcept : from_{other.from_}, size_{other.size_}, memory_{std::exchange(other.memory_, nullptr)} {}
    Room& operator=(Room&& other) noexcept {
        std::swap(from_, other.from_);
        std::swap(size_, other.size_);
        std::swap(memory_, other.memory_);
        return *this;
    }
    ~Room() {
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
