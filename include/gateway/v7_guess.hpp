// Guesses from the ids of V7 frames which device sends them, for proposals to people. V7 frames have no source.
#pragma once
#include <bitset>
#include <cstdint>
#include <span>
#include <string>

namespace anogate {

/// The ids of the complete valid V7 frames in `bytes`, which may begin and end inside a frame.
std::bitset<256> v7_ids_in(std::span<const std::uint8_t> bytes) noexcept;

/// The V8 id for `v7_device`: an optical flow sensor sends 0x51, an LX IMU 0x40 or 0xFA over its radio; other senders of telemetry are
/// taken for an LX IMU, and everything else for a board of the user. 0: `ids` is empty.
std::uint8_t guess_v7_device(const std::bitset<256>& ids) noexcept;

/// Whether only requests were received: their sender is a host program.
bool is_v7_host(const std::bitset<256>& ids) noexcept;

/// The keys of a link with that device: "protocol=v7,v7_device=0xDE".
std::string v7_link_keys(std::uint8_t device);

}    // namespace anogate
