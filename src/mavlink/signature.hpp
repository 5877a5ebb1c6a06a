// Signed packets of MAVLink 2: only those who know the key can send them, and none is accepted twice. No I/O, no clock.
#pragma once
#include <mavlink/packet.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string_view>
#include <tuple>

namespace anogate::mavlink {

using SigningKey = std::array<std::uint8_t, 32>;
/// The key that QGroundControl and Mission Planner make of a passphrase: its SHA-256.
SigningKey key_of_passphrase(std::string_view passphrase);

/// The time in signatures: units of 10 µs since 2015.
std::uint64_t signing_time(std::uint64_t unix_us) noexcept;

/// Signs a packet that was encoded with flag_signed and ends with its checksum: writes signature_size bytes behind it.
void sign(std::span<std::uint8_t> packet_with_room, const SigningKey& key, std::uint8_t link, std::uint64_t time);

class SignatureCheck {
public:
    static constexpr std::uint64_t max_age = 6'000'000;    // of the first packet of a sender: a minute
    static constexpr std::size_t max_senders = 64;

    explicit SignatureCheck(const SigningKey& key) : key_{key} {}
    /// Whether the packet is signed with the key and newer than all before from its sender on its link.
    bool accepts(PacketView packet, std::uint64_t now);

private:
    SigningKey key_;
    std::map<std::tuple<std::uint8_t, std::uint8_t, std::uint8_t>, std::uint64_t> newest_;    // by link, system and component
};

}    // namespace anogate::mavlink
