// Frames as the vendor's own programs and devices send them.
#pragma once
#include "bytes.hpp"

namespace support::vendor {

// A host asks all devices for their information; an MCU answers.
inline const Bytes who_are_you = hex("AB FE FF E0 03 00 00 00 00 8B 3B");
inline const Bytes i_am_an_mcu = hex("AB DB FE E3 0F 00 DB 64 00 64 00 00 00 20 03 41 6E 6F 4D 43 55 3F 2E");
// The host writes a parameter of the MCU; the MCU acknowledges.
inline const Bytes write_parameter = hex("AB FE DB E1 03 00 00 00 FA 62 3F");
inline const Bytes written = hex("AB DB FE 00 03 00 E1 62 3F 09 82");
// A command with all eleven bytes.
inline const Bytes command = hex("AB FE BA C0 0B 00 01 00 00 00 00 00 00 00 00 00 00 2F 3B");

}    // namespace support::vendor
