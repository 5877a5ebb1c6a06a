// Input crafted to be slow for a parser that looks again behind every candidate it refuses.
#pragma once
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <cstddef>
#include <functional>
#include <vector>

namespace support {

/// Appends some of itself; asked again until there is enough.
using Piece = std::function<void(Bytes&, Random&)>;

struct Crafted {
    const char* name;
    Piece piece;
    std::size_t max_data;
};

inline Piece repeat(Bytes pattern) {
    return [pattern](Bytes& input, Random&) { input.insert(input.end(), pattern.begin(), pattern.end()); };
}

/// `heads` headers overlap; the last one's LEN is drawn anew each time, from 0 to `largest`.
inline Piece headers_of_any_length(std::size_t heads, std::size_t largest) {
    return [=](Bytes& input, Random& random) {
        const std::size_t length = random.below(largest + 1);
        input.insert(input.end(), heads, ano::head);
        input.insert(input.end(), {0, 0, 0, static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(length >> 8)});
    };
}

/// A header every `step` bytes, and all their frames end where a run of `run` bytes ends.
inline Piece headers_that_just_fit(std::size_t step, std::size_t run) {
    return [=](Bytes& input, Random&) {
        Bytes bytes(run, 0);
        for (std::size_t at = 0; at + ano::overhead <= run; at += step) {
            const std::size_t length = run - at - ano::overhead;
            bytes[at] = ano::head;
            bytes[at + 4] = static_cast<std::uint8_t>(length);
            bytes[at + 5] = static_cast<std::uint8_t>(length >> 8);
        }
        input.insert(input.end(), bytes.begin(), bytes.end());
    };
}

inline Bytes input_of(const Piece& piece, std::size_t size) {
    Random random{1};
    Bytes input;
    while (input.size() < size) piece(input, random);
    return input;
}

inline std::vector<Crafted> crafted() {
    return {{"all_heads_64k", repeat({0xAB}), 65535},
            {"all_heads_too_long", repeat({0xAB}), 4096},
            {"seven_of_eight_64k", repeat({0xAB, 0xAB, 0xAB, 0xAB, 0xAB, 0xAB, 0xAB, 0}), 65535},
            {"two_of_three_64k", repeat({0xAB, 0xAB, 0}), 65535},    // no LEN is two HEADs
            {"every_second_byte", repeat({0xAB, 0}), 4096},
            {"every_fifth_byte", repeat({0xAB, 0, 0, 0, 1}), 4096},
            {"empty_frames", repeat({0xAB, 0xAB, 0xAB, 0xAB, 0, 0}), 4096},
            {"short_frames", repeat({0xAB, 0xAB, 0xAB, 0xAB, 8, 0}), 4096},
            {"short_frames_64k", repeat({0xAB, 0xAB, 0xAB, 0xAB, 8, 0}), 65535},
            {"sum_holds", repeat({0xAB, 0, 0, 0xA7, 10, 0}), 4096},    // but not the second check
            {"varied_short", headers_of_any_length(1, 40), 4096},
            {"varied", headers_of_any_length(1, 4096), 4096},
            {"varied_64k", headers_of_any_length(1, 65535), 65535},
            {"varied_heads", headers_of_any_length(4, 4096), 4096},
            {"varied_heads_64k", headers_of_any_length(4, 65535), 65535},
            {"just_fits", headers_that_just_fit(6, 4104), 4096},
            {"just_fits_64k", headers_that_just_fit(6, 65543), 65535}};
}

}    // namespace support
