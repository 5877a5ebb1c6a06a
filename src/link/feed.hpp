// Puts a datagram into a channel's parser and passes on the complete frames.
#pragma once
#include <link/link.hpp>

#include <algorithm>
#include <cstring>
#include <span>

namespace anogate {

/// Calls `on_frame` for each valid frame. The datagram may be larger than the parser's free space: it is fed in pieces.
template <class OnFrame>
void feed_datagram(ano::FrameParser& parser, std::span<const std::uint8_t> datagram, TimePoint now, OnFrame on_frame) {
    parser.begin_datagram(datagram, now);
    while (const auto frame = parser.next()) on_frame(*frame);
    while (!datagram.empty()) {
        const auto room = parser.prepare();
        const std::size_t n = std::min(room.size(), datagram.size());
        std::memcpy(room.data(), datagram.data(), n);
        parser.commit(n, now);
        datagram = datagram.subspan(n);
        while (const auto frame = parser.next()) on_frame(*frame);
    }
}

}    // namespace anogate
