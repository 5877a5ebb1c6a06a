// Random streams of MAVLink, with damage.
#include <mavlink/typed.hpp>

#include <gtest/gtest.h>
#include <support/mavlink_reference.hpp>
#include <support/random.hpp>

#include <algorithm>

namespace mavlink_parser_tests {
namespace {

using namespace anogate::mavlink;
using support::Bytes;
using support::Random;
using support::operator+;

Bytes random_packet(Random& random) {
    const Message& row = messages[random.below(messages.size())];
    Bytes payload(row.size);
    for (auto& byte : payload) byte = random.of<std::uint8_t>({0, random.byte(), magic_v1, magic_v2, 9});
    Bytes packet(max_packet);
    const Version version = random.one_in(4) && row.id < 256 ? Version::v1 : Version::v2;
    packet.resize(encode(packet, version, {random.byte(), 1}, random.byte(), row, payload));
    return packet;
}

// Damaged, truncated or missing packets, false headers, noise.
Bytes random_damage(Random& random) {
    Bytes bytes = random_packet(random);
    switch (random.below(4)) {
    case 0: bytes[random.below(bytes.size())] ^= static_cast<std::uint8_t>(1u << random.below(8u)); break;
    case 1: bytes.resize(random.below(bytes.size() - 2)); break;    // without the last byte, the next packet may complete it
    case 2: bytes = {random.of({magic_v1, magic_v2}), random.byte(), random.below(std::uint8_t{3}), 0, 0, 1, 1, 0, 0, 0}; break;
    default:
        bytes.resize(random.below(80u));
        for (auto& byte : bytes) byte = random.one_in(3) ? random.of({magic_v1, magic_v2}) : random.byte();
    }
    return bytes;
}

void feed_in_pieces(support::FedMavlinkParser& parser, std::span<const std::uint8_t> bytes, Random& random) {
    while (!bytes.empty()) {
        const std::size_t n = std::min(bytes.size(), 1 + random.below(random.of<std::size_t>({1, 20, 500})));
        parser.feed(bytes.first(n));
        bytes = bytes.subspan(n);
    }
    parser.give_up();
}

TEST(MavlinkParser, finds_what_the_reference_finds_however_the_stream_is_split) {
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        Random random{seed};
        const Transport transport = random.of({Transport::lossy, Transport::reliable});
        Bytes stream;
        for (int i = 0; i < 30; ++i) stream = stream + (random.one_in(3) ? random_damage(random) : random_packet(random));
        support::FedMavlinkParser parser{transport};
        feed_in_pieces(parser, stream, random);
        ASSERT_EQ(parser.packets(), support::mavlink_packets(stream, transport)) << "seed " << seed;
        ASSERT_EQ(parser.fault(), "") << "seed " << seed;
    }
}

TEST(MavlinkParser, loses_no_undamaged_packet_of_a_lossy_line) {
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        Random random{seed};
        Bytes stream;
        std::vector<Bytes> sent;
        for (int i = 0; i < 30; ++i) {
            if (random.one_in(3)) stream = stream + random_damage(random);
            sent.push_back(random_packet(random));
            stream = stream + sent.back();
        }
        support::FedMavlinkParser parser{Transport::lossy};
        feed_in_pieces(parser, stream, random);
        auto next = parser.packets().begin();
        for (const Bytes& packet : sent) {
            next = std::find(next, parser.packets().end(), packet);
            ASSERT_NE(next, parser.packets().end()) << "seed " << seed;
            ++next;
        }
    }
}

// The most candidates that a stream can have: each is complete, of a known message, and of the greatest length.
TEST(MavlinkParser, takes_linear_time_for_the_worst_stream) {
    Bytes stream(100'000);
    for (std::size_t i = 0; i < stream.size(); ++i)
        stream[i] = i % 10 < 2 ? (i % 10 == 0 ? magic_v2 : std::uint8_t{0xFF}) : std::uint8_t{0};
    support::FedMavlinkParser parser{Transport::lossy};
    parser.feed(stream);
    parser.give_up();
    EXPECT_TRUE(parser.packets().empty());
    EXPECT_EQ(parser.fault(), "");
}

}    // namespace
}    // namespace mavlink_parser_tests
