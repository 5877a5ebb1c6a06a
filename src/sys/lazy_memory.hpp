// The memory resource of the lazy arrays (ano/lazy_array.hpp).
#pragma once
#include <cstddef>

namespace anogate {

/// After this call, each lazy array is a separate memory mapping, which is unmapped when the array is freed.
void map_lazy_arrays_separately() noexcept;

/// Whether the system could provide `size` more bytes now.
bool memory_is_left(std::size_t size) noexcept;

}    // namespace anogate
