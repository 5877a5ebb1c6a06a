// The parser of V7 compared with the reference. The first byte is max_data; then each step is a byte modulo 8 and its arguments:
//
//   0 1 2   a length N, and N bytes that are read together
//   3       a length N, D_ADDR, ID, and N bytes: a valid frame of them
//   4       a length N, and N bytes: a datagram
//   5       milliseconds that pass
//   6       expire()
//   7       finish()
#include <support/v7_reference_parser.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

namespace {

using Rest = std::span<const std::uint8_t>;

constexpr std::size_t max_bytes = 20000;    // the reference takes quadratic time

std::uint8_t take_byte(Rest& rest) {
    if (rest.empty()) return 0;
    const std::uint8_t byte = rest.front();
    rest = rest.subspan(1);
    return byte;
}

Rest take(Rest& rest, std::size_t n) {
    n = std::min(n, rest.size());
    const Rest taken = rest.first(n);
    rest = rest.subspan(n);
    return taken;
}

void step(support::BothV7Parsers& both, Rest& rest) {
    const unsigned action = take_byte(rest) % 8u;
    switch (action) {
    case 3: {
        const std::size_t n = take_byte(rest);
        const std::uint8_t destination = take_byte(rest), id = take_byte(rest);
        std::array<std::uint8_t, ano::v7::max_frame_size> frame{};
        return both.put(std::span{frame}.first(ano::v7::encode(frame, destination, id, take(rest, n))));
    }
    case 4: return both.feed_datagram(take(rest, take_byte(rest)));
    case 5: both.now += std::chrono::milliseconds{take_byte(rest)}; return;
    case 6: return both.expire();
    case 7: return both.finish();
    default: return both.put(take(rest, take_byte(rest)));
    }
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Rest rest{data, std::min(size, max_bytes)};
    support::BothV7Parsers both{{.max_data = take_byte(rest)}};
    while (!rest.empty()) {
        step(both, rest);
        if (both.difference.empty()) continue;
        std::fprintf(stderr, "%s\n", both.difference.c_str());
        std::abort();
    }
    return 0;
}
