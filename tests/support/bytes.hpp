// Whole frames as vectors of bytes, for tests.
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace support {

using Bytes = std::vector<std::uint8_t>;

inline Bytes frame(std::uint8_t source, std::uint8_t destination, std::uint8_t id, const Bytes& data = {}) {
    Bytes bytes(ano::overhead + data.size());
    bytes.resize(ano::encode(bytes, source, destination, id, data));
    return bytes;
}

/// The bytes of hex digits: "AB FE FF".
inline Bytes hex(std::string_view text) {
    Bytes bytes;
    const auto digit = [](char c) { return c <= '9' ? c - '0' : (c | 0x20) - 'a' + 10; };
    for (std::size_t i = 0; i + 1 < text.size(); ++i) {
        if (text[i] == ' ') continue;
        bytes.push_back(static_cast<std::uint8_t>(digit(text[i]) << 4 | digit(text[i + 1])));
        ++i;
    }
    return bytes;
}

inline Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// The frames of a stream; `rest` contains the bytes after the last whole one. Nothing is skipped: bytes that are not a frame end
/// the list and belong to the rest.
struct Split {
    std::vector<Bytes> frames;
    Bytes rest;
};
inline Split split(std::span<const std::uint8_t> stream) {
    Split result;
    while (const auto frame = ano::frame_at(stream)) {
        result.frames.emplace_back(frame->bytes().begin(), frame->bytes().end());
        stream = stream.subspan(frame->bytes().size());
    }
    result.rest.assign(stream.begin(), stream.end());
    return result;
}

}    // namespace support
