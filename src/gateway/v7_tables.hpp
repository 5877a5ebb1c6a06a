// What V7 devices can do, as V8 describes it: V7 has no descriptions of commands and parameters (protocol-v7.md, sections 5, 6).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace anogate {

struct V7Command {
    std::array<std::uint8_t, 3> id;
    std::array<std::uint8_t, 3> types;    // of its values, as in 0xC2: 1 u8, 3 u16, 6 i32; 0: none
    std::string_view name;                // as V8 devices name it, at most 20 bytes
    std::string_view info;
};

std::span<const V7Command> v7_commands() noexcept;

}    // namespace anogate
