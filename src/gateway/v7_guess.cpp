#include <gateway/v7_guess.hpp>

#include <ano/hex.hpp>
#include <ano/v7.hpp>

namespace anogate {
namespace {

constexpr std::uint8_t lx_imu = 0xDD;

}    // namespace

std::bitset<256> v7_ids_in(std::span<const std::uint8_t> bytes) noexcept {
    std::bitset<256> ids;
    while (!bytes.empty()) {
        const auto frame = ano::v7::frame_at(bytes);
        if (frame) ids.set(frame->id());
        bytes = bytes.subspan(frame ? frame->bytes().size() : 1);
    }
    return ids;
}

std::uint8_t guess_v7_device(const std::bitset<256>& ids) noexcept {
    constexpr std::uint8_t flow = 0xDE, board_of_user = 1;
    if (ids.none()) return 0;
    if (ids[0x40] || ids[0xFA]) return lx_imu;
    if (ids[0x51]) return flow;
    for (std::size_t id = 0x01; id <= 0x0E; ++id)
        if (ids[id]) return lx_imu;
    return board_of_user;
}

bool is_v7_host(const std::bitset<256>& ids) noexcept {
    constexpr std::size_t check = 0x00, command = 0xE0, read = 0xE1, write = 0xE2;
    auto others = ids;
    for (const std::size_t id : {check, command, read, write}) others.reset(id);
    return others.none() && (ids[command] || ids[read]);
}

// The Euler angles of LX units have other signs than their quaternion (0x04).
std::string v7_link_keys(std::uint8_t device) {
    return "protocol=v7,v7_device=" + ano::hex_byte(device) + (device == lx_imu ? ",attitude=lx" : "");
}

}    // namespace anogate
