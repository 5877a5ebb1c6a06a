// A sanitizer has its own operator new, which compares every delete with its new: there the sanitizer is queried. Otherwise
// operator new is replaced for the whole program.
#include "allocations.hpp"

#include <cstddef>
#include <cstdlib>
#include <new>

std::uint64_t support::allocations = 0;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ANOGATE_ASK_THE_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define ANOGATE_ASK_THE_SANITIZER
#endif
#endif

#ifdef ANOGATE_ASK_THE_SANITIZER

extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                                         void (*on_free)(const volatile void*));

namespace {

[[maybe_unused]] const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { ++support::allocations; }, [](const volatile void*) {});

}    // namespace

#else

// Not inline: GCC would see malloc and delete in different places and warn about a mismatch.
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

#endif
