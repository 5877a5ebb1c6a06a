// MAVLink packets as the definition finds them, without any thought of speed, and the parser beside it.
#pragma once
#include <mavlink/packet_parser.hpp>
#include <support/bytes.hpp>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace support {

/// The packets in a whole input.
inline std::vector<Bytes> mavlink_packets(const Bytes& input, anogate::mavlink::Transport transport) {
    using namespace anogate::mavlink;
    const auto crc = [&](std::size_t from, std::size_t to, std::uint8_t extra) {
        unsigned value = 0xFFFF;
        for (std::size_t i = from; i <= to; ++i) {
            value ^= i < to ? input[i] : extra;
            for (int bit = 0; bit < 8; ++bit) value = (value & 1u) != 0 ? value >> 1 ^ 0x8408u : value >> 1;
        }
        return value;
    };
    std::vector<Bytes> found;
    for (std::size_t at = 0; at < input.size();) {
        const bool v2 = input[at] == 0xFD, v1 = input[at] == 0xFE;
        const std::size_t header = v2 ? 10 : 6, left = input.size() - at;
        const bool is_reliable = transport == Transport::reliable;
        std::size_t skip = 1, packet = 0;
        if ((v1 || v2) && left < header) {
            skip = is_reliable ? left : 1;
        } else if (v1 || v2) {
            const std::size_t length = input[at + 1], flags = v2 ? input[at + 2] : 0;
            const std::size_t size = header + length + 2 + (flags % 2 == 1 ? 13 : 0);
            const unsigned id = v2 ? input[at + 7] + 256u * input[at + 8] + 65536u * input[at + 9] : input[at + 5];
            const auto row = std::find_if(messages.begin(), messages.end(), [&](const Message& one) { return one.id == id; });
            const bool fits = size <= left;
            if (fits && row != messages.end() && flags < 2 &&
                crc(at + 1, at + header + length, row->crc_extra) ==
                    input[at + header + length] + 256u * input[at + header + length + 1])
                packet = size;
            skip = packet > 0 ? packet : is_reliable ? std::min(size, left) : 1;
        }
        if (packet > 0)
            found.emplace_back(input.begin() + static_cast<std::ptrdiff_t>(at),
                               input.begin() + static_cast<std::ptrdiff_t>(at + packet));
        at += skip;
    }
    return found;
}

/// The parser, fed with pieces.
class FedMavlinkParser {
public:
    explicit FedMavlinkParser(anogate::mavlink::Transport transport) : parser_{transport} {}

    void feed(std::span<const std::uint8_t> piece) {
        while (!piece.empty()) {
            const auto room = parser_.prepare();
            const std::size_t n = std::min(room.size(), piece.size());
            std::copy_n(piece.begin(), n, room.begin());
            parser_.commit(n);
            piece = piece.subspan(n);
            read();
        }
    }
    void give_up() {
        parser_.give_up();
        read();
    }
    const std::vector<Bytes>& packets() const { return packets_; }
    /// Empty: the counters agree with the packets.
    std::string fault() const {
        const auto& counters = parser_.counters();
        const std::size_t sum = packet_bytes_ + counters.skipped_bytes + parser_.waiting();
        return sum == counters.bytes_in && counters.packets == packets_.size() ? "" : "the counters do not add up";
    }

private:
    void read() {
        while (const auto packet = parser_.next()) {
            packets_.emplace_back(packet->bytes().begin(), packet->bytes().end());
            packet_bytes_ += packet->bytes().size();
        }
    }

    anogate::mavlink::PacketParser parser_;
    std::vector<Bytes> packets_;
    std::size_t packet_bytes_ = 0;
};

}    // namespace support
