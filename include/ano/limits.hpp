// Limits of the vendor's newest device library, which other devices in the field copied (protocol text, section 1).
#pragma once
#include <cstddef>
#include <cstdint>

namespace ano {

/// The maximum bytes of DATA that its parser accepts.
inline constexpr std::uint16_t vendor_max_data = 198;
/// The maximum bytes of a text parameter that it stores.
inline constexpr std::size_t vendor_max_text = 29;

}    // namespace ano
