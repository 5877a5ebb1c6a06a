// The parser of MAVLink compared with the reference. The first byte: bit 0: a reliable transport; the rest: bytes per piece.
#include <support/mavlink_reference.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t max_bytes = 20'000;
    if (size == 0 || size > max_bytes) return 0;
    using anogate::mavlink::Transport;
    const Transport transport = (data[0] & 1u) != 0 ? Transport::reliable : Transport::lossy;
    const std::size_t at_once = 1 + data[0] / 2u;
    const support::Bytes input(data + 1, data + size);
    support::FedMavlinkParser parser{transport};
    for (std::span<const std::uint8_t> rest{input}; !rest.empty();) {
        const auto piece = rest.first(std::min(rest.size(), at_once));
        parser.feed(piece);
        rest = rest.subspan(piece.size());
    }
    parser.give_up();
    if (parser.packets() == support::mavlink_packets(input, transport) && parser.fault().empty()) return 0;
    std::fprintf(stderr, "differs from the reference %s\n", parser.fault().c_str());
    std::abort();
}
