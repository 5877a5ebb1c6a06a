// Any bytes as a pcapng file.
#include <support/recorded.hpp>

#include <cstdint>
#include <cstdlib>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size > 65536) return 0;
    if (!support::holds_the_laws_of_recordings({reinterpret_cast<const char*>(data), size})) std::abort();
    return 0;
}
