// Simulates a serial line that is full of telemetry and has false headers, and measures the delay of valid frames in the parser.
// Time is simulated, the seed is fixed.
#pragma once
#include <ano/parser.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

namespace support {

enum class Noise {
    random_headers,         // HEAD and five random bytes: LEN is mostly above max_data
    headers_to_max_data,    // the same, but LEN is 0 to max_data
    flipped_len,            // one bit of LEN of a telemetry frame flipped
};

struct NoisyLine {
    std::uint32_t baud = 115200;
    Noise noise = Noise::random_headers;
    unsigned noise_one_in = 20;    // noise follows one frame in this many on average
    std::size_t at_once = 62;      // bytes that the driver passes together: those of an FTDI's USB packet
    std::size_t frames = 20'000;
    std::size_t max_data = 4096;
    std::uint64_t seed = 1;
};

/// The delays of valid frames from their last byte on the wire until the parser returned them.
struct Delays {
    std::size_t sent = 0;
    std::size_t in_time = 0;    // within 20 ms + the time of two frames of its size
    std::size_t lost = 0;
    std::chrono::duration<double> longest{};

    double share_in_time() const { return static_cast<double>(in_time) / static_cast<double>(sent); }
};

namespace noisy_line {

struct Sent {
    Bytes bytes;
    std::size_t end;    // offset of its end in the stream
};

struct Stream {
    Bytes bytes;
    std::vector<Sent> good;
};

// Frames of a flight controller and an optical flow sensor; each contains its number.
inline Bytes telemetry(std::size_t number) {
    struct Kind {
        std::uint8_t source, id;
        std::size_t length;
    };
    static constexpr std::array kinds{Kind{0xDC, 0x01, 13}, Kind{0xDC, 0x03, 7},  Kind{0xDC, 0x04, 9},  Kind{0xDC, 0x05, 13},
                                      Kind{0xDC, 0x06, 5},  Kind{0xDC, 0x07, 6},  Kind{0xDC, 0x08, 12}, Kind{0xDE, 0x51, 15},
                                      Kind{0xDC, 0x20, 16}, Kind{0xDC, 0x40, 20}, Kind{0xDC, 0x0D, 4},  Kind{0xDC, 0x30, 23}};
    const Kind& kind = kinds[number % kinds.size()];
    Bytes data(kind.length);
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(number >> (i % 4 * 8) ^ 37 * i);
    return frame(kind.source, 0xFE, kind.id, data);
}

inline void append_noise(Bytes& stream, const NoisyLine& line, Random& random, std::size_t number) {
    if (line.noise == Noise::flipped_len) {
        Bytes bad = telemetry(number);
        const unsigned bit = random.below(16u);
        bad[4 + bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
        stream.insert(stream.end(), bad.begin(), bad.end());
        return;
    }
    const std::size_t lengths = line.noise == Noise::random_headers ? 65536 : line.max_data + 1;
    const std::size_t length = random.below(lengths);
    stream.insert(stream.end(), {ano::head, random.byte(), random.byte(), random.byte(), static_cast<std::uint8_t>(length),
                                 static_cast<std::uint8_t>(length >> 8)});
}

// There is no noise before the first hundred frames.
inline Stream stream_of(const NoisyLine& line) {
    Random random{line.seed};
    Stream stream;
    for (std::size_t i = 0; i < line.frames; ++i) {
        if (i > 100 && random.one_in(line.noise_one_in)) append_noise(stream.bytes, line, random, line.frames + i);
        const Bytes bytes = telemetry(i);
        stream.bytes.insert(stream.bytes.end(), bytes.begin(), bytes.end());
        stream.good.push_back({bytes, stream.bytes.size()});
    }
    return stream;
}

}    // namespace noisy_line

inline Delays delays_on(const NoisyLine& line) {
    using Seconds = std::chrono::duration<double>;
    const noisy_line::Stream stream = noisy_line::stream_of(line);
    const double rate = line.baud / 10.0;    // bytes/s, 8N1
    const auto time_of = [=](std::size_t bytes) { return Seconds{static_cast<double>(bytes) / rate}; };
    ano::FrameParser parser{{.max_data = line.max_data, .line_rate = line.baud / 10}};
    Delays delays{.sent = stream.good.size()};
    std::size_t next = 0;
    ano::TimePoint now{};
    const auto take = [&] {
        while (const auto frame = parser.next()) {
            const auto is_it = [&](const noisy_line::Sent& s) { return std::ranges::equal(frame->bytes(), s.bytes); };
            const auto from = stream.good.begin() + static_cast<std::ptrdiff_t>(next);
            const auto found = std::find_if(from, stream.good.end(), is_it);
            if (found == stream.good.end()) continue;    // noise that is a valid frame by chance
            const Seconds delay = now.time_since_epoch() - time_of(found->end);
            delays.lost += static_cast<std::size_t>(found - from);
            delays.in_time += delay <= Seconds{0.020} + 2 * time_of(found->bytes.size());
            delays.longest = std::max(delays.longest, delay);
            next = static_cast<std::size_t>(found - stream.good.begin()) + 1;
        }
    };
    for (std::size_t at = 0; at < stream.bytes.size();) {
        const std::size_t n = std::min(line.at_once, stream.bytes.size() - at);
        const ano::TimePoint came{std::chrono::duration_cast<ano::Duration>(time_of(at + n))};
        for (auto due = parser.deadline(); due && *due <= came; due = parser.deadline()) {
            now = *due;
            if (parser.expire(now)) take();
        }
        now = came;
        std::copy_n(stream.bytes.begin() + static_cast<std::ptrdiff_t>(at), n, parser.prepare().begin());
        parser.commit(n, now);
        take();
        at += n;
    }
    parser.finish();
    take();
    delays.lost += stream.good.size() - next;
    return delays;
}

}    // namespace support
