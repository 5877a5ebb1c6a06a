// The time of frames on a CAN bus: the data sizes of the CAN frames that make up a V8 frame, and the bits of each.
#pragma once
#include <gateway/can_stream.hpp>

#include <algorithm>
#include <vector>

namespace can_rate {

using Sizes = std::vector<std::size_t>;    // the data of each CAN frame, in order

inline Sizes stream(std::size_t frame, bool fd) {
    Sizes sizes;
    for (std::size_t room = fd ? 64 : 8; frame > 0; frame -= std::min(frame, room))
        sizes.push_back(anogate::can_fd_size(std::min(frame, room)));
    return sizes;
}

/// ISO 15765-2 as implemented by the kernel: a single frame, or a first frame, the peer's flow control (3 bytes), and consecutive
/// frames, without padding beyond the requirements of CAN FD.
inline Sizes isotp(std::size_t frame, bool fd) {
    const std::size_t room = fd ? 64 : 8;
    if (frame <= 7) return {frame + 1};
    if (frame + 2 <= room && fd) return {anogate::can_fd_size(frame + 2)};
    Sizes sizes{room, 3};
    for (std::size_t rest = frame - (room - 2); rest > 0; rest -= std::min(rest, room - 1))
        sizes.push_back(anogate::can_fd_size(std::min(rest, room - 1) + 1));
    return sizes;
}

/// The seconds that a CAN frame with an 11-bit id occupies the bus, without stuff bits except those that CAN FD always has.
/// `data_rate` 0: classic.
inline double seconds(std::size_t size, double rate, double data_rate) {
    const auto bits = static_cast<double>(8 * size);
    if (data_rate == 0) return (47 + bits) / rate;    // 44 and the space of 3 to the next frame
    // Start to BRS 17, ACK to the space 12; ESI, DLC, data, stuff count, CRC with its fixed stuff bits, delimiter.
    const double crc = size <= 16 ? 17 + 5 : 21 + 6;
    return 29 / rate + (1 + 4 + bits + 4 + crc + 1) / data_rate;
}

inline double seconds(const Sizes& sizes, double rate, double data_rate) {
    double all = 0;
    for (const std::size_t size : sizes) all += seconds(size, rate, data_rate);
    return all;
}

}    // namespace can_rate
