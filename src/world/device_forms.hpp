// Variants of the protocol that simulated devices can imitate.
#pragma once
#include <cstdint>

namespace ano::world {

/// The form of its parameter descriptions (0xE2).
enum class ParameterForm : std::uint8_t { typed, minmax, scaled };

/// Language and encoding of its names and texts: English, or Chinese in UTF-8 or GBK.
enum class TextForm : std::uint8_t { en, utf8, gbk };

}    // namespace ano::world
