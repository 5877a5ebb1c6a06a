#include <daemon/rooms.hpp>

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

// Where huge pages are for everybody, the first byte that is touched of a room would cost 2 MB.
void keep_pages_small() noexcept { ::prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0); }

}    // namespace

// To the C library's heap they would be pieces like others, whatever its threshold for mmap: that is asked only where the heap has to
// grow. Else a room comes from what small pieces left or from the heap's spare end, with pages that others have touched, and what is
// put behind it keeps it there.
void take_rooms_from_the_system() noexcept {
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
