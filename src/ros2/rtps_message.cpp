#include <ros2/rtps_message.hpp>

#include <algorithm>
#include <string_view>

namespace anogate {
namespace {

constexpr std::size_t header_size = 20, submessage_header_size = 4;
constexpr std::uint8_t version = 2;
constexpr std::uint8_t little_endian = 0x01;    // flag
constexpr std::uint8_t of_vendors = 0x80;       // ids from here on

struct Submessage {
    std::uint8_t id;
    std::size_t least;    // bytes after its header
};

constexpr Submessage submessages[] = {
    {0x01, 0},     // PAD
    {0x06, 24},    // ACKNACK: with a set of no numbers
    {0x07, 28},    // HEARTBEAT
    {0x08, 28},    // GAP
    {0x09, 0},     // INFO_TS
    {0x0C, 20},    // INFO_SRC
    {0x0E, 12},    // INFO_DST
    {0x12, 28},    // NACK_FRAG
    {0x13, 24},    // HEARTBEAT_FRAG
    {0x15, 20},    // DATA
    {0x16, 32},    // DATA_FRAG
};

constexpr std::uint8_t pad = 0x01, info_timestamp = 0x09;

}    // namespace

std::size_t valid_part(std::span<const std::uint8_t> datagram) noexcept {
    constexpr std::string_view magic = "RTPS";
    if (datagram.size() < header_size || !std::equal(magic.begin(), magic.end(), datagram.begin()) || datagram[4] != version)
        return 0;
    std::size_t end = header_size;
    while (datagram.size() - end >= submessage_header_size) {
        const auto at = datagram.subspan(end);
        const auto* const known = std::find_if(std::begin(submessages), std::end(submessages),
                                               [&](const Submessage& one) { return one.id == at[0]; });
        const bool is_little = (at[1] & little_endian) != 0;
        auto size = static_cast<std::size_t>(is_little ? at[2] | at[3] << 8 : at[2] << 8 | at[3]);
        const std::size_t rest = at.size() - submessage_header_size;
        if (size == 0 && at[0] != pad && at[0] != info_timestamp) size = rest;    // the last one, of any size
        if (at[0] >= of_vendors || size > rest || (known != std::end(submessages) && size < known->least)) break;
        end += submessage_header_size + size;
    }
    return end == header_size ? 0 : end;
}

}    // namespace anogate
