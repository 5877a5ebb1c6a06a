// Generations of devices that a simulated device can be of.
#pragma once
#include <cstdint>

namespace ano::world {

/// How it describes its parameters (0xE2).
enum class ParameterForm : std::uint8_t { typed, minmax, scaled };

/// In which language and encoding it has its names and texts: English, or Chinese in UTF-8 or GBK.
enum class TextForm : std::uint8_t { en, utf8, gbk };

}    // namespace ano::world
