// The message between listening sockets of gateways: a special frame (0xFB) that is never routed. Devices ignore it.
#pragma once
#include <ano/frame.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace anogate {

/// A question contains a random number that only its receiver can repeat.
struct ListeningNotice {
    enum class Kind : std::uint8_t {
        question = 1,    // this socket listens for peers; does yours?
        answer = 2,      // yes; repeats the number of the question
    };
    Kind kind{};
    std::uint64_t number = 0;
    friend bool operator==(const ListeningNotice&, const ListeningNotice&) = default;
};

namespace listening {
inline constexpr std::uint8_t id = 0xFB, source = 0xFE, destination = 0xFF;
inline constexpr std::array<std::uint8_t, 4> magic = {'a', 'n', 'o', 'L'};
inline constexpr std::size_t data_size = magic.size() + 1 + 8;
}    // namespace listening

using NoticeFrame = std::array<std::uint8_t, ano::overhead + listening::data_size>;

inline NoticeFrame frame_of(const ListeningNotice& notice) noexcept {
    std::array<std::uint8_t, listening::data_size> data{};
    std::copy(listening::magic.begin(), listening::magic.end(), data.begin());
    data[4] = static_cast<std::uint8_t>(notice.kind);
    for (std::size_t i = 0; i < 8; ++i) data[5 + i] = static_cast<std::uint8_t>(notice.number >> 8 * i);
    NoticeFrame frame;
    ano::encode(frame, listening::source, listening::destination, listening::id, data);
    return frame;
}

inline std::optional<ListeningNotice> listening_notice(ano::FrameView frame) noexcept {
    const auto data = frame.data();
    if (frame.id() != listening::id || frame.source() != listening::source || frame.destination() != listening::destination ||
        data.size() != listening::data_size || !std::equal(listening::magic.begin(), listening::magic.end(), data.begin()) ||
        data[4] < 1 || data[4] > 2)
        return std::nullopt;
    ListeningNotice notice{static_cast<ListeningNotice::Kind>(data[4]), 0};
    for (std::size_t i = 0; i < 8; ++i) notice.number |= std::uint64_t{data[5 + i]} << 8 * i;
    return notice;
}

}    // namespace anogate
