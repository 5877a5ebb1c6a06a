// Packets against bytes that another implementation (node-mavlink) wrote; all messages are compared in tests/mavlink.
#include <mavlink/packet_parser.hpp>
#include <mavlink/typed.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace mavlink_codec_tests {
namespace {

using namespace anogate::mavlink;
using support::Bytes;
using support::hex;
using support::operator+;

template <class Draft>
Bytes packet_of(const Draft& draft, Version version = Version::v2, std::uint8_t sequence = 0) {
    Bytes bytes(max_packet);
    bytes.resize(encode(bytes, version, {1, 1}, sequence, Draft::row, draft.payload()));
    return bytes;
}

Draft<"HEARTBEAT"> heartbeat() {
    Draft<"HEARTBEAT"> draft;
    draft.set<"type">(2).set<"autopilot">(12).set<"base_mode">(0x51).set<"custom_mode">(0x04030201).set<"system_status">(3);
    draft.set<"mavlink_version">(3);
    return draft;
}

std::vector<Bytes> packets_in(PacketParser& parser, const Bytes& bytes) {
    std::vector<Bytes> found;
    for (std::size_t at = 0; at < bytes.size();) {
        const auto room = parser.prepare();
        const std::size_t n = std::min(room.size(), bytes.size() - at);
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), n, room.begin());
        parser.commit(n);
        at += n;
        while (const auto packet = parser.next()) found.emplace_back(packet->bytes().begin(), packet->bytes().end());
    }
    return found;
}

std::vector<Bytes> packets_in(Transport transport, const Bytes& bytes, bool gives_up = true) {
    PacketParser parser{transport};
    std::vector<Bytes> found = packets_in(parser, bytes);
    if (!gives_up) return found;
    parser.give_up();
    while (const auto packet = parser.next()) found.emplace_back(packet->bytes().begin(), packet->bytes().end());
    EXPECT_EQ(parser.waiting(), 0u);
    return found;
}

TEST(Encode, writes_a_heartbeat_as_others_do) {
    EXPECT_EQ(packet_of(heartbeat(), Version::v2, 7), hex("FD 09 00 00 07 01 01 00 00 00 01 02 03 04 02 0C 51 03 03 26 18"));
    EXPECT_EQ(packet_of(heartbeat(), Version::v1, 7), hex("FE 09 07 01 01 00 01 02 03 04 02 0C 51 03 03 78 19"));
}

TEST(Encode, leaves_out_zeros_at_the_end_in_version_2_but_never_the_first_byte) {
    const Draft<"PARAM_REQUEST_LIST"> zeros;
    EXPECT_EQ(packet_of(zeros).size(), header_v2 + 1 + crc_size);
    EXPECT_EQ(packet_of(zeros, Version::v1).size(), header_v1 + 2 + crc_size);
}

TEST(Encode, leaves_out_extensions_in_version_1) {
    Draft<"MISSION_COUNT"> draft;
    draft.set<"count">(3).set<"mission_type">(1);
    EXPECT_EQ(PacketView{packet_of(draft, Version::v1)}.payload().size(), 4u);
    EXPECT_EQ(PacketView{packet_of(draft)}.payload().size(), 5u);
}

TEST(Encode, writes_nothing_for_an_id_that_version_1_has_not) {
    std::array<std::uint8_t, max_packet> room{};
    const Draft<"PROTOCOL_VERSION"> draft;
    EXPECT_EQ(encode(room, Version::v1, {1, 1}, 0, draft.row, draft.payload()), 0u);
    EXPECT_EQ(encode(std::span{room}.first(5), Version::v2, {1, 1}, 0, draft.row, draft.payload()), 0u);
}

TEST(Draft, limits_and_rounds_values_for_integer_fields) {
    Draft<"GPS_RAW_INT"> draft;
    draft.set<"eph">(70000.0).set<"vel">(-1.0).set<"cog">(99.5).set<"lat">(std::nan("")).set<"lon">(1e12);
    const View<"GPS_RAW_INT"> view{draft.payload()};
    EXPECT_EQ(view.get<"eph">(), 65535);
    EXPECT_EQ(view.get<"vel">(), 0);
    EXPECT_EQ(view.get<"cog">(), 100);
    EXPECT_EQ(view.get<"lat">(), 0);
    EXPECT_EQ(view.get<"lon">(), std::numeric_limits<std::int32_t>::max());
}

TEST(View, fills_what_was_left_out_with_zeros) {
    Draft<"STATUSTEXT"> draft;
    draft.set<"severity">(4).set_text<"text">("low battery");
    const Bytes bytes = packet_of(draft);
    EXPECT_EQ(bytes.size(), header_v2 + 12 + crc_size);
    const auto view = as<"STATUSTEXT">(PacketView{bytes});
    ASSERT_TRUE(view);
    EXPECT_EQ(view->get<"text">(), "low battery");
    EXPECT_EQ(view->get<"id">(), 0);
    EXPECT_FALSE(as<"HEARTBEAT">(PacketView{bytes}));
}

TEST(View, ends_text_at_its_first_nul_or_at_the_end_of_the_field) {
    Draft<"PARAM_VALUE"> draft;
    draft.set_text<"param_id">("SIXTEEN_LETTERS_AND_MORE");
    EXPECT_EQ(View<"PARAM_VALUE">{draft.payload()}.get<"param_id">(), "SIXTEEN_LETTERS_");
}

TEST(PacketParser, reads_packets_of_both_versions) {
    const Bytes v2 = packet_of(heartbeat()), v1 = packet_of(heartbeat(), Version::v1);
    for (const Transport transport : {Transport::lossy, Transport::reliable})
        EXPECT_EQ(packets_in(transport, v2 + v1 + v2), (std::vector<Bytes>{v2, v1, v2}));
}

TEST(PacketParser, recognises_signed_packets) {
    const Bytes packet = hex(
        "FD 09 01 00 09 FF BE 00 00 00 01 02 03 04 02 0C 51 03 03 61 44 05 00 E0 6F 9E 75 19 50 A7 E0 5C F5 A0");
    const auto found = packets_in(Transport::lossy, packet + packet_of(heartbeat()));
    ASSERT_EQ(found.size(), 2u);
    const PacketView view{found[0]};
    EXPECT_TRUE(view.is_signed());
    EXPECT_EQ(view.signature().size(), signature_size);
    EXPECT_EQ(view.signature()[0], 5);    // the link id
    EXPECT_FALSE(PacketView{found[1]}.is_signed());
}

TEST(PacketParser, loses_no_packet_after_a_damaged_one) {
    const Bytes good = packet_of(heartbeat());
    for (std::size_t i = 0; i < good.size(); ++i) {
        for (const int value : {0x00, 0x20, 0xFD, 0xFE, 0xFF}) {
            Bytes damaged = good;
            if (damaged[i] == value) continue;
            damaged[i] = static_cast<std::uint8_t>(value);
            EXPECT_EQ(packets_in(Transport::lossy, damaged + good + good), (std::vector<Bytes>{good, good})) << i << ' ' << value;
        }
    }
}

TEST(PacketParser, loses_no_packet_after_a_truncated_one) {
    const Bytes good = packet_of(heartbeat());
    for (std::size_t n = 0; n < good.size(); ++n)
        EXPECT_EQ(packets_in(Transport::lossy, Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n)) + good),
                  (std::vector<Bytes>{good}));
}

TEST(PacketParser, waits_for_the_rest_of_a_packet) {
    const Bytes good = packet_of(heartbeat());
    PacketParser parser{Transport::lossy};
    for (std::size_t i = 0; i + 1 < good.size(); ++i) EXPECT_TRUE(packets_in(parser, {good[i]}).empty());
    EXPECT_EQ(parser.waiting(), good.size() - 1);
    EXPECT_EQ(packets_in(parser, {good.back()}), (std::vector<Bytes>{good}));
    EXPECT_EQ(parser.counters().skipped_bytes, 0u);
}

TEST(PacketParser, does_not_carry_out_packets_inside_of_others_on_a_reliable_transport) {
    const Bytes inner = packet_of(heartbeat());
    const Bytes unknown = hex("FD 15 00 00 00 FF BE 80 01 00") + inner + hex("12 34");    // TUNNEL
    ASSERT_EQ(inner.size(), 0x15u);
    EXPECT_EQ(packets_in(Transport::reliable, unknown + inner), (std::vector<Bytes>{inner}));
    EXPECT_EQ(packets_in(Transport::lossy, unknown + inner), (std::vector<Bytes>{inner, inner}));
}

TEST(PacketParser, skips_the_rest_of_a_datagram_that_ends_within_a_packet) {
    const Bytes good = packet_of(heartbeat());
    PacketParser parser{Transport::reliable};
    EXPECT_TRUE(packets_in(parser, Bytes(good.begin(), good.begin() + 15)).empty());
    parser.give_up();
    EXPECT_FALSE(parser.next());
    EXPECT_EQ(packets_in(parser, good), (std::vector<Bytes>{good}));
    EXPECT_EQ(parser.counters().skipped_bytes, 15u);
}

TEST(PacketParser, refuses_packets_with_unknown_incompatible_flags) {
    Bytes bytes = packet_of(heartbeat());
    bytes[2] = 0x02;
    Crc crc;
    crc.add(std::span{bytes}.subspan(1, bytes.size() - 3));
    crc.add(std::uint8_t{50});
    bytes[bytes.size() - 2] = static_cast<std::uint8_t>(crc.value());
    bytes[bytes.size() - 1] = static_cast<std::uint8_t>(crc.value() >> 8);
    EXPECT_TRUE(packets_in(Transport::lossy, bytes).empty());
}

TEST(PacketParser, accepts_a_payload_that_is_longer_than_the_definition) {
    const Message& row = Draft<"MISSION_REQUEST_LIST">::row;
    Bytes bytes = hex("FD 06 00 00 01 FF BE 2B 00 00 01 01 00 00 00 09");
    Crc crc;
    crc.add(std::span{bytes}.subspan(1));
    crc.add(row.crc_extra);
    bytes.push_back(static_cast<std::uint8_t>(crc.value()));
    bytes.push_back(static_cast<std::uint8_t>(crc.value() >> 8));
    EXPECT_EQ(packets_in(Transport::lossy, bytes), (std::vector<Bytes>{bytes}));
}

TEST(SequenceWatch, counts_lost_packets_and_wraps) {
    SequenceWatch watch;
    EXPECT_EQ(watch.on_packet(254), 0u);
    EXPECT_EQ(watch.on_packet(255), 0u);
    EXPECT_EQ(watch.on_packet(0), 0u);
    EXPECT_EQ(watch.on_packet(3), 2u);
}

}    // namespace
}    // namespace mavlink_codec_tests
