// Input crafted to be slow for a parser that searches again after every candidate it refuses.
#pragma once
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace support {

/// Appends some bytes; called repeatedly until there are enough.
using Piece = std::function<void(Bytes&, Random&)>;

struct Crafted {
    std::string name;
    Piece piece;
    std::size_t max_data;
};

inline Piece repeat(Bytes pattern) {
    return [pattern](Bytes& input, Random&) { input.insert(input.end(), pattern.begin(), pattern.end()); };
}

/// `heads` overlapping headers; LEN of the last one is chosen at random each time, from 0 to `largest`.
inline Piece headers_of_any_length(std::size_t heads, std::size_t largest) {
    return [=](Bytes& input, Random& random) {
        const std::size_t length = random.below(largest + 1);
        input.insert(input.end(), heads, ano::head);
        input.insert(input.end(), {0, 0, 0, static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(length >> 8)});
    };
}

/// A header every `step` bytes; the frames of all of them end at the end of the run of `run` bytes.
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

/// Copies of `piece`, after valid frames of the sources 0xAB, 0 and 0xA7. Before each `run` bytes there is a header of the
/// largest frame from 0x77, an unknown source: while it waits for its rest, the parser searches for two frames in a row after it.
inline Piece behind_false_headers(const Piece& piece, std::size_t run, std::size_t max_data) {
    return [=, next = std::size_t{0}](Bytes& input, Random& random) mutable {
        if (input.empty()) {
            for (const std::uint8_t source : {ano::head, std::uint8_t{0}, std::uint8_t{0xA7}}) {
                const Bytes heard = frame(source, 0xFF, 0xE0, {1, 0, 0});
                input.insert(input.end(), heard.begin(), heard.end());
            }
            next = 0;
        }
        if (input.size() >= next) {
            input.insert(input.end(),
                         {ano::head, 0x77, 0, 1, static_cast<std::uint8_t>(max_data), static_cast<std::uint8_t>(max_data >> 8)});
            next = input.size() + run;
        }
        piece(input, random);
    };
}

/// Valid frames, but never two in a row.
inline void lonely_frames(Bytes& input, Random&) {
    const Bytes lonely = frame(0, 0xFF, 0xE0, {1, 0, 0});
    input.insert(input.end(), lonely.begin(), lonely.end());
    input.push_back(0);
}

/// Two valid frames in a row after `headers` headers that the parser must give up for them.
inline Piece pair_behind_headers(std::size_t headers, std::size_t max_data) {
    return [=](Bytes& input, Random& random) {
        for (std::size_t i = 0; i < headers; ++i) {
            const std::size_t length = max_data - random.below(std::min<std::size_t>(max_data, 100));
            input.insert(input.end(), {ano::head, random.of<std::uint8_t>({0, 0x77}), 0, 1, static_cast<std::uint8_t>(length),
                                       static_cast<std::uint8_t>(length >> 8)});
        }
        const Bytes one = frame(0, 0xFF, 0xE0, {1, 0, 0});
        for (int i = 0; i < 2; ++i) input.insert(input.end(), one.begin(), one.end());
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
            {"two_of_three_64k", repeat({0xAB, 0xAB, 0}), 65535},    // no LEN consists of two HEADs
            {"every_second_byte", repeat({0xAB, 0}), 4096},
            {"every_fifth_byte", repeat({0xAB, 0, 0, 0, 1}), 4096},
            {"empty_frames", repeat({0xAB, 0xAB, 0xAB, 0xAB, 0, 0}), 4096},
            {"short_frames", repeat({0xAB, 0xAB, 0xAB, 0xAB, 8, 0}), 4096},
            {"short_frames_64k", repeat({0xAB, 0xAB, 0xAB, 0xAB, 8, 0}), 65535},
            {"sum_holds", repeat({0xAB, 0, 0, 0xA7, 10, 0}), 4096},    // the first check holds, the second does not
            {"varied_short", headers_of_any_length(1, 40), 4096},
            {"varied", headers_of_any_length(1, 4096), 4096},
            {"varied_64k", headers_of_any_length(1, 65535), 65535},
            {"varied_heads", headers_of_any_length(4, 4096), 4096},
            {"varied_heads_64k", headers_of_any_length(4, 65535), 65535},
            {"just_fits", headers_that_just_fit(6, 4104), 4096},
            {"just_fits_64k", headers_that_just_fit(6, 65543), 65535}};
}

/// Input crafted to be slow for the search for two valid frames in a row.
inline std::vector<Crafted> crafted_for_pairs() {
    std::vector<Crafted> all;
    for (const Crafted& c : crafted())
        all.push_back({"behind_" + c.name, behind_false_headers(c.piece, c.max_data / 3, c.max_data), c.max_data});
    for (const std::size_t max_data : {4096u, 65535u}) {
        const std::string size = max_data == 4096 ? "" : "_64k";
        all.push_back({"lonely" + size, behind_false_headers(lonely_frames, max_data / 3, max_data), max_data});
        for (const std::size_t headers : {1u, 2u, 100u})
            all.push_back({"pair_behind_" + std::to_string(headers) + size,
                           behind_false_headers(pair_behind_headers(headers, max_data), max_data / 3, max_data), max_data});
    }
    return all;
}

}    // namespace support
