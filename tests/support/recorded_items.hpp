// A few frames and losses, as in recordings.
#pragma once
#include "bytes.hpp"
#include "recorded.hpp"

#include <cstdint>
#include <string>
#include <utility>

namespace support {

inline const anogate::RecordingHead anoctl_head{"anoctl 0.1.0", 1'763'898'044'123'456'789, 1'234'567'890'123};
inline const Bytes euler_frame = frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
inline const Bytes wind_frame = frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});

inline KeptItem came(const Bytes& frame, std::string link = "fc") {
    KeptItem item;
    item.time_ns = anoctl_head.time_ns + 1;
    item.boottime_ns = anoctl_head.boottime_ns + 1;
    item.link = std::move(link);
    item.frame = frame;
    return item;
}

inline KeptItem lost(std::uint64_t count, std::string names) {
    KeptItem item;
    item.lost = count;
    item.names = std::move(names);
    return item;
}

}    // namespace support
