// The cost of a byte from the read to the frame: valid frames, noise, and input crafted to be slow. Crafted input should cost at
// most twice as much as valid frames of 21 bytes. Input arrives in reads of 4096 bytes; the copy is included.
#include <ano/parser.hpp>
#include <support/crafted.hpp>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <string>

using support::Bytes;
using support::Random;

namespace {

constexpr std::size_t input_size = 1 << 20;
constexpr std::size_t read_size = 4096;

void parse(benchmark::State& state, const support::Piece& piece, std::size_t max_data) {
    const Bytes input = support::input_of(piece, input_size);
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

void append(Bytes& to, const Bytes& bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

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

void mixed_frames(Bytes& input, Random& random) { frames(random.below(60u))(input, random); }

void damaged_frames(Bytes& input, Random& random) {
    Bytes frame = support::frame(0xDC, 0xFE, 1, random_bytes(random, 13));
    frame[8] ^= 1;
    append(input, frame);
}

void noise(Bytes& input, Random& random) { append(input, random_bytes(random, 4096)); }

BENCHMARK_CAPTURE(parse, good_21, frames(13), 4096);
BENCHMARK_CAPTURE(parse, good_8_to_67, mixed_frames, 4096);
BENCHMARK_CAPTURE(parse, good_198, frames(198), 4096);
BENCHMARK_CAPTURE(parse, good_64k, frames(65535), 65535);

BENCHMARK_CAPTURE(parse, noise, noise, 4096);
BENCHMARK_CAPTURE(parse, noise_64k, noise, 65535);
BENCHMARK_CAPTURE(parse, damaged_21, damaged_frames, 4096);

const bool crafted = [] {
    for (const auto& [name, piece, max_data] : support::crafted())
        benchmark::RegisterBenchmark((std::string{"parse/crafted_"} + name).c_str(), parse, piece, max_data);
    return true;
}();

}    // namespace
