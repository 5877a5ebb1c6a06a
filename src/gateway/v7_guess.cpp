#include <gateway/v7_guess.hpp>

#include <ano/hex.hpp>
#include <ano/v7.hpp>

namespace anogate {

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
    constexpr std::uint8_t lx_imu = 0xDD, flow = 0xDE, board_of_user = 1;
    if (ids.none()) return 0;
    if (ids[0x40] || ids[0xFA]) return lx_imu;
    if (ids[0x51]) return flow;
    for (std::size_t id = 0x01; id <= 0x0E; ++id)
        if (ids[id]) return lx_imu;
    return board_of_user;
}

std::string v7_link_keys(std::uint8_t device) { return "protocol=v7,v7_device=" + ano::hex_byte(device); }

}    // namespace anogate
