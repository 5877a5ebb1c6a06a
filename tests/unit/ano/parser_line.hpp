// A FrameParser on a line: bytes are put in, whole frames are taken out, and every byte is counted.
#pragma once
#include <ano/parser.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace parsing {

using namespace std::chrono_literals;
using ano::FrameParser;
using ano::TimePoint;
using support::Bytes;
using support::operator+;
using Frames = std::vector<Bytes>;

// Puts bytes in, takes whole frames out, and checks that every byte is counted.
class Line {
public:
    explicit Line(FrameParser::Options options = {}) : parser{options} {}

    FrameParser parser;
    TimePoint now{};
    Frames frames;

    void put(std::span<const std::uint8_t> bytes, std::size_t at_once = SIZE_MAX) {
        while (!bytes.empty()) {
            const auto room = parser.prepare();
            ASSERT_FALSE(room.empty());
            const std::size_t n = std::min({room.size(), bytes.size(), at_once});
            std::copy_n(bytes.data(), n, room.data());
            parser.commit(n, now);
            bytes = bytes.subspan(n);
            take();
        }
    }
    void feed_datagram(const Bytes& bytes, std::size_t at_once = SIZE_MAX) {
        parser.begin_datagram(bytes, now);
        take();
        put(bytes, at_once);
    }
    // Gives up all candidates that can be given up now.
    void expire() {
        while (parser.expire(now)) take();
    }
    void finish() {
        parser.finish();
        take();
    }
    void pass(ano::Duration time) { now += time; }
    const ano::ParserCounters& counters() const { return parser.counters(); }

private:
    void take() {
        while (const auto frame = parser.next()) {
            frames.emplace_back(frame->bytes().begin(), frame->bytes().end());
            good_bytes_ += frame->bytes().size();
            conserve();
        }
        conserve();
    }
    void conserve() {
        const auto& c = parser.counters();
        ASSERT_EQ(c.bytes_in, good_bytes_ + c.skipped_bytes + parser.waiting());
    }
    std::uint64_t good_bytes_ = 0;
};

// A frame of 21 bytes whose content depends on `n`.
inline Bytes numbered(unsigned n) {
    Bytes data(13, 0x11);
    data[0] = static_cast<std::uint8_t>(n);
    data[1] = static_cast<std::uint8_t>(n >> 8);
    return support::frame(0xDC, 0xFE, 0x01, data);
}

inline Bytes header(std::size_t length, std::uint8_t source = 0xDC, std::uint8_t id = 0x01) {
    return {ano::head, source, 0xFE, id, static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(length >> 8)};
}

inline Bytes begin_of(const Bytes& bytes, std::size_t n) {
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)};
}
inline Bytes rest_of(const Bytes& bytes, std::size_t n) { return {bytes.begin() + static_cast<std::ptrdiff_t>(n), bytes.end()}; }

// The beginning of a frame that contains two frames, up to the end of both: as much as a datagram may contain.
struct Tunnel {
    Bytes first = numbered(1);
    Bytes second = numbered(2);
    Bytes whole = support::frame(0xDC, 0xFE, 0xB1, Bytes(10) + first + second + Bytes(10));
    std::size_t cut = ano::header_size + 10 + 42 + 2;
};

// A frame of the previous version of the protocol.
inline Bytes v7_frame(std::uint8_t id, const Bytes& data) {
    Bytes bytes = Bytes{0xAA, 0xFF, id, static_cast<std::uint8_t>(data.size())} + data;
    const ano::Checks checks = ano::checks_of(bytes);
    return bytes + Bytes{checks.sum, checks.add};
}

}    // namespace parsing
