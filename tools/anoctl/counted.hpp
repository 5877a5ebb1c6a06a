// Numbers of frames and bytes, which may not fit into a std::size_t of 32 bits.
#pragma once
#include <cstdint>
#include <string>

namespace anoctl {

/// "1 frame", "3 frames"
inline std::string counted(std::uint64_t number, const char* word) {
    return std::to_string(number) + ' ' + word + (number == 1 ? "" : "s");
}

}    // namespace anoctl
