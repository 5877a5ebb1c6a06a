// What a byte costs from the read to the frame: good frames, noise, and input crafted to be slow. Crafted input should
// not cost more than twice what good frames of 21 bytes cost. Input goes in by reads of 4096 bytes, the copy included.
#include <ano/parser.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <functional>

using support::Bytes;
using support::Random;

namespace {

constexpr std::size_t input_size = 1 << 20;
constexpr std::size_t read_size = 4096;

void parse(benchmark::State& state, const std::function<void(Bytes&, Random&)>& add, std::size_t max_data) {
    Random random{1};
    Bytes input;
    while (input.size() < input_size) add(input, random);
    ano::FrameParser parser{{.max_data = max_data}};
    for (auto _ : state) {
        for (std::size_t at = 0; at < input.size();) {
            const auto room = parser.prepare();
            const std::size_t n = std::min({room.size(), read_size, input.size() - at});
            std::memcpy(room.data(), input.data() + at, n);
            parser.commit(n, {});
            while (auto frame = parser.next()) benchmark::DoNotOptimize(frame);
            at += n;
        }
    }
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(input.size()));
    const auto& c = parser.counters();
    const auto total = static_cast<double>(c.bytes_in);
    state.counters["frames/KiB"] = 1024 * static_cast<double>(c.frames_in) / total;
    state.counters["refused/KiB"] = 1024 * static_cast<double>(c.bad_check + c.bad_length) / total;
}

void append(Bytes& to, const Bytes& bytes) {
    to.insert(to.end(), bytes.begin(), bytes.end());
}

Bytes random_bytes(Random& random, std::size_t n) {
    Bytes bytes(n);
    for (auto& byte : bytes) byte = random.byte();
    return bytes;
}

auto frames(std::size_t data_size) {
    return [data_size](Bytes& input, Random& random) {
        append(input, support::frame(0xDC, 0xFE, 1, random_bytes(random, data_size)));
    };
}

void mixed_frames(Bytes& input, Random& random) {
    frames(random.below(60u))(input, random);
}

void damaged_frames(Bytes& input, Random& random) {
    Bytes frame = support::frame(0xDC, 0xFE, 1, random_bytes(random, 13));
    frame[8] ^= 1;
    append(input, frame);
}

void noise(Bytes& input, Random& random) {
    append(input, random_bytes(random, 4096));
}

auto repeat(Bytes pattern) {
    return [pattern](Bytes& input, Random&) { append(input, pattern); };
}

// `heads` headers overlap; the last one's LEN is drawn anew each time, from 0 to `largest`.
auto headers_of_any_length(std::size_t heads, std::size_t largest) {
    return [=](Bytes& input, Random& random) {
        const std::size_t length = random.below(largest + 1);
        input.insert(input.end(), heads, ano::head);
        append(input, {0, 0, 0, static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(length >> 8)});
    };
}

// A header every `step` bytes, and all their frames end where a run of `run` bytes ends.
auto headers_that_just_fit(std::size_t step, std::size_t run) {
    return [=](Bytes& input, Random&) {
        Bytes bytes(run, 0);
        for (std::size_t at = 0; at + ano::overhead <= run; at += step) {
            const std::size_t length = run - at - ano::overhead;
            bytes[at] = ano::head;
            bytes[at + 4] = static_cast<std::uint8_t>(length);
            bytes[at + 5] = static_cast<std::uint8_t>(length >> 8);
        }
        append(input, bytes);
    };
}

BENCHMARK_CAPTURE(parse, good_21, frames(13), 4096);
BENCHMARK_CAPTURE(parse, good_8_to_67, mixed_frames, 4096);
BENCHMARK_CAPTURE(parse, good_198, frames(198), 4096);
BENCHMARK_CAPTURE(parse, good_64k, frames(65535), 65535);

BENCHMARK_CAPTURE(parse, noise, noise, 4096);
BENCHMARK_CAPTURE(parse, noise_64k, noise, 65535);
BENCHMARK_CAPTURE(parse, damaged_21, damaged_frames, 4096);

BENCHMARK_CAPTURE(parse, crafted_all_heads_64k, repeat({0xAB}), 65535);
BENCHMARK_CAPTURE(parse, crafted_all_heads_too_long, repeat({0xAB}), 4096);
BENCHMARK_CAPTURE(parse, crafted_seven_of_eight_64k, repeat({0xAB, 0xAB, 0xAB, 0xAB, 0xAB, 0xAB, 0xAB, 0}), 65535);
BENCHMARK_CAPTURE(parse, crafted_every_second_byte, repeat({0xAB, 0}), 4096);
BENCHMARK_CAPTURE(parse, crafted_every_fifth_byte, repeat({0xAB, 0, 0, 0, 1}), 4096);
BENCHMARK_CAPTURE(parse, crafted_empty_frames, repeat({0xAB, 0xAB, 0xAB, 0xAB, 0, 0}), 4096);
BENCHMARK_CAPTURE(parse, crafted_short_frames, repeat({0xAB, 0xAB, 0xAB, 0xAB, 8, 0}), 4096);
BENCHMARK_CAPTURE(parse, crafted_short_frames_64k, repeat({0xAB, 0xAB, 0xAB, 0xAB, 8, 0}), 65535);
BENCHMARK_CAPTURE(parse, crafted_sum_holds, repeat({0xAB, 0, 0, 0xA7, 10, 0}), 4096);    // but not the second check
BENCHMARK_CAPTURE(parse, crafted_varied_short, headers_of_any_length(1, 40), 4096);
BENCHMARK_CAPTURE(parse, crafted_varied, headers_of_any_length(1, 4096), 4096);
BENCHMARK_CAPTURE(parse, crafted_varied_64k, headers_of_any_length(1, 65535), 65535);
BENCHMARK_CAPTURE(parse, crafted_varied_heads, headers_of_any_length(4, 4096), 4096);
BENCHMARK_CAPTURE(parse, crafted_varied_heads_64k, headers_of_any_length(4, 65535), 65535);
BENCHMARK_CAPTURE(parse, crafted_just_fits, headers_that_just_fit(6, 4104), 4096);
BENCHMARK_CAPTURE(parse, crafted_just_fits_64k, headers_that_just_fit(6, 65543), 65535);

}    // namespace
