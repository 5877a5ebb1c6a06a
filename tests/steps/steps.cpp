#include "steps.hpp"

#include <cstddef>

namespace support {

std::uint64_t steps = 0;

}    // namespace support

constexpr std::size_t bytes_a_step = 16;    // of what the C library does a vector at a time

extern "C" {

void __sanitizer_cov_trace_pc();
void __sanitizer_cov_trace_pc() { ++support::steps; }

void* __real_memchr(const void* bytes, int byte, std::size_t size);
void* __wrap_memchr(const void* bytes, int byte, std::size_t size);
void* __wrap_memchr(const void* bytes, int byte, std::size_t size) {
    void* const found = __real_memchr(bytes, byte, size);
    const std::size_t seen = found ? static_cast<std::size_t>(static_cast<const char*>(found) - static_cast<const char*>(bytes))
                                   : size;
    support::steps += 1 + seen / bytes_a_step;
    return found;
}

void* __real_memmove(void* to, const void* from, std::size_t size);
void* __wrap_memmove(void* to, const void* from, std::size_t size);
void* __wrap_memmove(void* to, const void* from, std::size_t size) {
    support::steps += 1 + size / bytes_a_step;
    return __real_memmove(to, from, size);
}

void* __real_memset(void* bytes, int byte, std::size_t size);
void* __wrap_memset(void* bytes, int byte, std::size_t size);
void* __wrap_memset(void* bytes, int byte, std::size_t size) {
    support::steps += 1 + size / bytes_a_step;
    return __real_memset(bytes, byte, size);
}
}
