#include <sys/lazy_memory.hpp>

#include <memory_resource>
#include <new>

#include <sys/mman.h>
#include <sys/prctl.h>

namespace anogate {
namespace {

class Mapped final : public std::pmr::memory_resource {
    void* do_allocate(std::size_t size, std::size_t) override {
        void* const room = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (room == MAP_FAILED) throw std::bad_alloc{};
        return room;
    }
    void do_deallocate(void* room, std::size_t size, std::size_t) override { ::munmap(room, size); }
    bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
};

// With huge pages enabled for all programs, the first touched byte of a room would cost 2 MB.
void keep_pages_small() noexcept { ::prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0); }

}    // namespace

// The heap of the C library would not map each room separately, because it uses its threshold for mmap only when the heap has to
// grow. Otherwise it would allocate a room from freed small pieces or from the free end of the heap, where pages were touched
// before, and pieces allocated after it would keep its memory in the heap.
void map_lazy_arrays_separately() noexcept {
    static Mapped mapped;
    std::pmr::set_default_resource(&mapped);
    keep_pages_small();
}

bool memory_is_left(std::size_t size) noexcept {
    void* const room = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED) return false;
    ::munmap(room, size);
    return true;
}

}    // namespace anogate
