// Counts allocations. Replaces operator new for the whole program: include it in one source of it only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace support {

inline std::uint64_t allocations = 0;

}    // namespace support

// Not inline: GCC would see malloc in one and delete in another place, and warn of a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++support::allocations;
    if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
    throw std::bad_alloc{};
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
// Called by the memory resources of the standard library.
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
    ++support::allocations;
    const auto to = static_cast<std::size_t>(alignment);
    if (void* memory = std::aligned_alloc(to, (size + to) / to * to)) return memory;
    throw std::bad_alloc{};
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void* operator new[](std::size_t size) { return operator new(size); }
void operator delete[](void* memory) noexcept { operator delete(memory); }
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
void operator delete[](void* memory, std::size_t) noexcept { operator delete(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t alignment) noexcept { operator delete(memory, alignment); }
